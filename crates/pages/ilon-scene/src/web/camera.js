// A camera that orbits a target: heading and elevation as angles, and a distance, about the
// vertical.

const FOV = 0.6;

class Camera {
  constructor(yaw, pitch, distance) {
    Object.assign(this, { yaw, pitch, distance, target: [0, 0, 0] });
  }

  // The eye and the axes of the picture: right, up, and towards the viewer.
  axes() {
    const [sy, cy, sp, cp] = [Math.sin(this.yaw), Math.cos(this.yaw), Math.sin(this.pitch), Math.cos(this.pitch)];
    const back = [cp * cy, cp * sy, sp];
    return { right: [-sy, cy, 0], up: [-sp * cy, -sp * sy, cp], back, eye: add(this.target, times(back, this.distance)) };
  }

  // Clip coordinates from points in the floor's frame, which is tilted by the slope; the picture is
  // shifted by parts of its half.
  matrix(aspect, levelFromFloor, [right_by, up_by]) {
    const { right, up, back, eye } = this.axes();
    const rows = [right, up, back];
    const view = [...rows.flatMap((axis) => [...axis, -dot(axis, eye)])];
    const m = mul(view, levelFromFloor);
    const columns = [
      m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0, m[3], m[7], m[11], 1,
    ];
    const clip = mul4(perspective(FOV, aspect, this.distance * 0.02, this.distance * 60), columns);
    for (let c = 0; c < 16; c += 4) {
      clip[c] += right_by * clip[c + 3];
      clip[c + 1] += up_by * clip[c + 3];
    }
    return clip;
  }

  // The ray through a point of the picture, both coordinates from -1 to 1.
  ray(x, y, aspect) {
    const { right, up, back, eye } = this.axes();
    const half = Math.tan(FOV / 2);
    return { eye, way: unit(add(add(times(right, x * half * aspect), times(up, y * half)), times(back, -1))) };
  }

  orbit(dx, dy) {
    this.yaw -= dx;
    this.pitch = clamp(this.pitch + dy, 0.03, 1.55);
  }

  zoom(factor, least, most) { this.distance = clamp(this.distance * factor, least, most); }
}
