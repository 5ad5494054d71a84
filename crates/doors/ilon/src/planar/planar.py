"""A planar base that moves as ilon's robot did: numbers in planar.json, made by `ilon export --planar`."""
import csv, json, pathlib
import numpy as np


class Base:
    """Twists are (ahead in m/s, to the left in m/s, turning in rad/s), in the body frame."""

    def __init__(self, file):
        fit = json.loads(pathlib.Path(file).read_text())
        self.S = np.array(fit["shortfall"]["matrix"])
        self.kp, self.ki = (np.array(fit["lag"][k]) for k in ("proportional_per_s", "integral_per_s2"))
        self.most, self.p = np.array(fit["grip"]["most"]), fit["grip"]["exponent"]
        self.step_s = fit["step_s"]
        self.reset()

    def reset(self):
        self.pose, self.v, self.z = np.zeros(3), np.zeros(3), np.zeros(3)

    def step(self, asked, dt):
        """Goes on for dt seconds with a twist that is asked; the twist that the body then has."""
        parts = max(1, int(np.ceil(dt / self.step_s)))
        h, target = dt / parts, self.S @ asked
        for _ in range(parts):
            e, carried = target - self.v, np.array([-self.v[2] * self.v[1], self.v[2] * self.v[0], 0.0])
            a = self.kp * e + self.ki * self.z + carried
            taken = (np.abs(a / self.most) ** self.p).sum() ** (1 / self.p)
            if taken <= 1:
                self.z = self.z + h * e
            self.v = self.v + h * (a / max(1, taken) - carried)
        self.pose = moved(self.pose, self.v, dt)
        return self.v


def moved(pose, v, dt):
    """A pose (x, y, heading) after dt seconds of a twist of the body."""
    c, s = np.cos(pose[2] + v[2] * dt / 2), np.sin(pose[2] + v[2] * dt / 2)
    return pose + dt * np.array([c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]])


if __name__ == "__main__":  # how far it is off from ilon on the drives that were held out
    folder, off, rows = pathlib.Path(__file__).parent, {}, csv.reader(open(pathlib.Path(__file__).with_name("held_out.csv")))
    base, drive = Base(folder / "planar.json"), None
    for number, t, *twists in [[float(x) for x in row] for row in list(rows)[1:]]:
        if number != drive:
            drive, before, truth = number, 0.0, np.zeros(3)
            base.reset()
        dt, before = t - before, t
        truth, v = moved(truth, twists[3:], dt), base.step(np.array(twists[:3]), dt)
        off.setdefault(drive, []).append([*(v - twists[3:]), *(base.pose - truth), np.hypot(*twists[3:5]) * dt])
    off = [np.array(rows) for rows in off.values()]
    over_path = [np.hypot(*rows[-1, 3:5]) / rows[:, 6].sum() for rows in off]
    rms = lambda x: np.sqrt(np.mean(np.square(x), axis=0))
    print(json.dumps({"twist_rms": list(rms(np.concatenate(off)[:, :3])), "position_over_path": np.mean(over_path),
                      "heading_rms_rad": rms([rows[-1, 5] for rows in off])}))
