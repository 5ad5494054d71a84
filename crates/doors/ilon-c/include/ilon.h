/* ilon: simulates omnidirectional robots down to the rollers of their wheels.
 *
 * A handle is a number. One that was freed, made up, or is of another kind is refused with a code. Any thread may call with any handle; one
 * plant serves one thread at a time, and a second one is refused with ILON_STATUS_BUSY. No call unwinds. Of every call that fails
 * ilon_last_error() says why, a text for each thread. A pointer that is not null must point at as much memory as the call says. A calling
 * thread needs 256 kB of stack, however deep a file is nested: files are read on a thread of the library.
 *
 * Made by cbindgen from crates/doors/ilon-c: do not edit. */

#ifndef ILON_H
#define ILON_H

#include <stddef.h>
#include <stdint.h>

// Increases whenever a program built with an older header would no longer work.
#define ILON_ABI_VERSION 1

// The result of a call. All except 0 are failures, which `ilon_last_error` explains.
typedef enum {
  // Success.
  ILON_STATUS_OK = 0,
  // A pointer is null or misaligned, or a text is not UTF-8.
  ILON_STATUS_POINTER = 1,
  // A handle is unknown: freed, made up, or of another kind.
  ILON_STATUS_HANDLE = 2,
  // An array is too short or too long.
  ILON_STATUS_COUNT = 3,
  // A number is not finite or out of its range, or a snapshot is of another plant. The state is
  // unchanged.
  ILON_STATUS_VALUE = 4,
  // The scenario, or the robot that it names, cannot be read or is invalid.
  ILON_STATUS_SCENARIO = 5,
  // The robot's motion is no longer finite. Reset or restore it.
  ILON_STATUS_DIVERGED = 6,
  // Another thread is using this plant. The state is unchanged.
  ILON_STATUS_BUSY = 7,
  // An internal error of ilon. The plant accepts only the call that frees it.
  ILON_STATUS_INTERNAL = 8,
} IlonStatus;

// A simulated robot in its world. 0 is none.
typedef uint64_t IlonPlant;

// A position in the ground plane and a heading.
typedef struct {
  // In metres.
  double x_m;
  // In metres.
  double y_m;
  // About the floor's normal, in radians, from -pi to pi.
  double heading_rad;
} IlonPose;

// The constant properties of a plant.
typedef struct {
  // The number of wheels: the length of every array of wheels.
  uint32_t wheel_count;
  // The number of joints between bodies: the length of every array of joints.
  uint32_t joint_count;
  // The physics step, in seconds. With sampled or late wheel loops a period is
  // a whole number of them.
  double physics_dt_s;
  // The control period of the scenario, in seconds.
  double control_dt_s;
  // The limit of the wheel rates, in rad/s; infinite for none.
  double wheel_rate_limit_rad_s;
  // Coulomb friction coefficient of the floor in the scenario.
  double floor_friction;
  // The seed of the scenario's noise.
  uint64_t seed;
  // The start pose in the scenario.
  IlonPose start;
} IlonAbout;

// The true state of the robot as a whole, independent of its sensors.
typedef struct {
  // Simulated time since the start or the last reset, in seconds.
  double time_s;
  // The body frame's origin in the world, in metres.
  double position_m[3];
  // Orientation of the body in the world: a unit quaternion w, x, y, z.
  double quaternion_wxyz[4];
  // Roll about the body's x axis, in radians.
  double roll_rad;
  // Pitch about the body's y axis, in radians.
  double pitch_rad;
  // Heading about the floor's normal, in radians.
  double heading_rad;
  // Velocity of the body frame's origin, in the body frame, in m/s.
  double velocity_in_body_m_s[3];
  // Angular velocity in the body frame, in rad/s.
  double angular_in_body_rad_s[3];
  // Acceleration of the body frame's origin in the world frame, in m/s^2: the mean over the last
  // advance. An accelerometer there measures this minus gravity.
  double acceleration_in_world_m_s2[3];
  // The acceleration of gravity in the world frame, in m/s^2. On a slope it is tilted.
  double gravity_in_world_m_s2[3];
  // The load of the wheels along the floor's normal, in N, in the last physics step.
  double wheels_load_n;
  // The load of a chassis that touches the ground, in N.
  double chassis_load_n;
  // The force of walls, kerbs and bumps on the robot, in the world frame's x and y, in N.
  double obstacle_force_n[2];
  // The largest violation of the contact laws in the last advance, in m/s.
  double contact_residual_m_s;
} IlonState;

// A wheel and its contact with the ground. Forces, slip and place are means over the last advance.
typedef struct {
  // Angle about the wheel's axis since the start, in radians, not wrapped.
  double angle_rad;
  // Rate about the wheel's axis, in rad/s.
  double rate_rad_s;
  // Motor torque on the wheel, in N m: the mean over the last advance.
  double torque_n_m;
  // Height of the wheel's centre above the floor's plane, in metres.
  double hub_height_m;
  // The load: the ground's normal force, in N.
  double normal_force_n;
  // The ground's tangential force on the wheel, in the body frame's x and y, in N.
  double force_in_body_n[2];
  // Slip: the velocity of the rollers' surface over the ground, in the body frame's x and y, in
  // m/s.
  double slip_in_body_m_s[2];
  // The contact point in the body frame, in metres.
  double place_in_body_m[3];
  // Coulomb friction coefficient under the roller with the largest normal force.
  double friction;
  // Power converted to heat by sliding in the last physics step, in W.
  double slip_power_w;
  // The roller with the largest normal force at the end of the last advance.
  uint32_t roller;
  // 1 if any roller touches the ground, 0 otherwise.
  uint32_t touching;
} IlonWheel;

// A joint between bodies of the robot, such as of a rocker or a sprung wheel. Values are in rad
// and N m for a revolute joint, in m and N for a prismatic one.
typedef struct {
  // Displacement from zero.
  double position;
  // Rate of the displacement.
  double rate;
  // Force or torque of spring, damper, friction and stops on the joint's body in the last
  // physics step.
  double force;
} IlonJoint;

// Stored energies, and the energy exchanged since the start, in J. The work of motors and outside
// equals the sum of all others.
typedef struct {
  // Kinetic energy of all bodies.
  double kinetic_j;
  // Potential energy of height and springs.
  double potential_j;
  // Work of the motors on the wheels.
  double motor_j;
  // Work of external wrenches and payloads.
  double outside_j;
  // Heat of sliding.
  double slip_j;
  // Energy lost in spinning up rollers that touch down.
  double spin_up_j;
  // Heat of bearings and gears.
  double bearing_j;
  // Energy lost to the normal forces.
  double impact_j;
} IlonEnergies;

// The saved state of a plant. 0 is none.
typedef uint64_t IlonSnapshot;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The reason for the last failed call of this thread, in UTF-8, or an empty text. The text is
// valid until the next call of this thread fails, or the thread ends; never null.
const char *ilon_last_error(void);

// The version of the functions and structs of this library; compare it with `ILON_ABI_VERSION` of
// the header.
uint32_t ilon_abi_version(void);

// The version of ilon, such as "0.1.0". Never null.
const char *ilon_version(void);

// Loads a scenario from a TOML file and places its robot at the start, at rest.
//
// On success the handle is in `plant`; free it with `ilon_plant_free`. What moves the robot in the
// scenario is ignored: only the advance functions drive it.
IlonStatus ilon_plant_load(const char *path, IlonPlant *plant);

// Like `ilon_plant_load`, but from a scenario's text. Its relative paths start from `folder`.
IlonStatus ilon_plant_parse(const char *toml, const char *folder, IlonPlant *plant);

// Frees a plant. Its handle is refused from then on; its snapshots stay valid.
IlonStatus ilon_plant_free(IlonPlant plant);

// The constant properties of a plant: counts, periods, limits.
IlonStatus ilon_plant_about(IlonPlant plant, IlonAbout *about);

// The name of a wheel's joint, with a terminating zero, into a buffer of `size` bytes.
IlonStatus ilon_plant_wheel_name(IlonPlant plant, size_t wheel, char *buffer, size_t size);

// Restarts a plant at rest: time zero, noise from `seed`, the robot at `pose`, or at the
// scenario's start if that is null. Wrench, payload and grip are cleared, and friction is the
// scenario's.
IlonStatus ilon_plant_reset(IlonPlant plant, uint64_t seed, const IlonPose *pose);

// Advances by a period in seconds while the wheel loops follow rates in rad/s, one per wheel. With
// sampled wheel loops the period must be a whole number of physics steps.
IlonStatus ilon_plant_advance_rates(IlonPlant plant, const double *rates_rad_s, size_t count, double period_s);

// Advances by a period in seconds while the motors apply torques in N m to the wheels, one per
// wheel and within their limits.
IlonStatus ilon_plant_advance_torques(IlonPlant plant, const double *torques_n_m, size_t count, double period_s);

// The true state of the robot as a whole.
IlonStatus ilon_plant_state(IlonPlant plant, IlonState *state);

// The wheels with their contacts; `count` is that of `IlonAbout`.
IlonStatus ilon_plant_wheels(IlonPlant plant, IlonWheel *wheels, size_t count);

// The joints between bodies; `count` is that of `IlonAbout`.
IlonStatus ilon_plant_joints(IlonPlant plant, IlonJoint *joints, size_t count);

// Stored energies, and the energy exchanged since the start.
IlonStatus ilon_plant_energies(IlonPlant plant, IlonEnergies *energies);

// The current sensor readings, with noise, delay and faults: the robot's pose, and the rates in
// rad/s and angles in rad of its wheels. Each of the three pointers may be null.
IlonStatus ilon_plant_observe(IlonPlant plant, IlonPose *pose, double *rates_rad_s, double *angles_rad, size_t count);

// The wheel rates in rad/s at which a robot without wheel slip has a twist: vx and vy in m/s and
// omega in rad/s, in the body frame.
IlonStatus ilon_plant_rates_for_twist(IlonPlant plant, const double *twist, double *rates_rad_s, size_t count);

// Applies a force in N and a moment in N m to the chassis, both in the world frame: three numbers
// each, or null for zero. The force acts at a point in the body frame in metres, or at the
// chassis's centre of mass if that is null. Both act until the next call.
IlonStatus ilon_plant_set_wrench(IlonPlant plant,
                                 const double *force_in_world_n,
                                 const double *moment_in_world_n_m,
                                 const double *place_in_body_m);

// Puts a mass in kg on the robot and replaces the previous one; 0 removes it. Its place is in the
// body frame in metres, or the chassis's centre of mass if that is null.
IlonStatus ilon_plant_set_payload(IlonPlant plant, double mass_kg, const double *place_in_body_m);

// Changes the Coulomb friction coefficient of the floor, except on its patches.
IlonStatus ilon_plant_set_friction(IlonPlant plant, double friction);

// Changes the direction of gravity, as on a slope: three numbers in the world frame; 0, 0, -1 is
// level ground.
IlonStatus ilon_plant_set_down(IlonPlant plant, const double *down_in_world);

// Couples the chassis to bodies that your program simulates, by their articulated-body inertia: 36
// numbers, row by row, linear at the body frame's origin before angular, along the world's axes,
// in kg, kg m and kg m^2. Set also the wrench that these bodies apply to an unaccelerated chassis.
// Both engines are then coupled without a delay, whatever the masses. All zeros end the coupling.
IlonStatus ilon_plant_set_articulated_inertia(IlonPlant plant, const double *inertia);

// Scales the ground's friction under the rollers of a wheel by a share; 1 for full friction.
IlonStatus ilon_plant_set_grip(IlonPlant plant, size_t wheel, double share);

// Saves the state of a plant. On success the handle is in `snapshot`; free it with
// `ilon_snapshot_free`.
IlonStatus ilon_plant_snapshot(IlonPlant plant, IlonSnapshot *snapshot);

// Restores a snapshot of this plant, or of another plant of the same scenario; the simulation then
// continues bit-identically.
IlonStatus ilon_plant_restore(IlonPlant plant, IlonSnapshot snapshot);

// Frees a snapshot.
IlonStatus ilon_snapshot_free(IlonSnapshot snapshot);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ILON_H */
