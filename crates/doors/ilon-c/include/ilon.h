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

// Grows whenever a program that was built with an older header would go wrong.
#define ILON_ABI_VERSION 1

// How a call ended. All but 0 are failures, which `ilon_last_error` explains.
typedef enum {
  // It was done.
  ILON_STATUS_OK = 0,
  // A pointer is null or misaligned, or a text is not UTF-8.
  ILON_STATUS_POINTER = 1,
  // A handle is unknown: freed, made up, or of another kind.
  ILON_STATUS_HANDLE = 2,
  // An array is too short or too long.
  ILON_STATUS_COUNT = 3,
  // A number is not finite or out of its range, or a snapshot is of another plant. Nothing has happened.
  ILON_STATUS_VALUE = 4,
  // The scenario, or the robot that it names, cannot be read or makes no sense.
  ILON_STATUS_SCENARIO = 5,
  // The robot's motion is no number any more. Reset or restore it.
  ILON_STATUS_DIVERGED = 6,
  // Another thread is using this plant. Nothing has happened.
  ILON_STATUS_BUSY = 7,
  // A fault of ilon itself. The plant takes no call any more but the one that frees it.
  ILON_STATUS_INTERNAL = 8,
} IlonStatus;

// A simulated robot in its world. 0 is none.
typedef uint64_t IlonPlant;

// A place in the ground plane and a heading.
typedef struct {
  // In metres.
  double x_m;
  // In metres.
  double y_m;
  // About the floor's normal, in radians, from -pi to pi.
  double heading_rad;
} IlonPose;

// What stays as it is while a plant lives.
typedef struct {
  // How many wheels the robot has: the length of every array of wheels.
  uint32_t wheel_count;
  // How many joints between its bodies: the length of every array of joints.
  uint32_t joint_count;
  // The step of the physics, in seconds. Every period is a whole number of it.
  double physics_dt_s;
  // The control period of the scenario, in seconds.
  double control_dt_s;
  // The rate that wheels are held to, in rad/s; infinite where there is no limit.
  double wheel_rate_limit_rad_s;
  // Coulomb's coefficient of friction with which the floor was built.
  double floor_friction;
  // The seed of the scenario's noise.
  uint64_t seed;
  // Where the scenario has the robot start.
  IlonPose start;
} IlonAbout;

// The robot as a whole, as it really is, whatever its sensors say.
typedef struct {
  // Simulated time since the start or the last reset, in seconds.
  double time_s;
  // The body frame's origin in the world, in metres.
  double position_m[3];
  // How the body is turned in the world: a unit quaternion w, x, y, z.
  double quaternion_wxyz[4];
  // Roll about the body's x axis, in radians.
  double roll_rad;
  // Pitch about the body's y axis, in radians.
  double pitch_rad;
  // Heading about the floor's normal, in radians.
  double heading_rad;
  // Velocity of the body frame's origin, in the body frame, in m/s.
  double velocity_in_body_m_s[3];
  // Rates about the axes of the body frame, in rad/s.
  double angular_in_body_rad_s[3];
  // Acceleration of the body frame's origin in the world frame, in m/s^2: the mean over the last advance. What an accelerometer there
  // feels is this less gravity.
  double acceleration_in_world_m_s2[3];
  // The acceleration of gravity in the world frame, in m/s^2. On a slope it leans.
  double gravity_in_world_m_s2[3];
  // What the wheels carry along the floor's normal, in N, in the last physics step.
  double wheels_load_n;
  // What the chassis carries where it lies on the ground, in N.
  double chassis_load_n;
  // How walls, kerbs and bumps push the robot, in the world frame's x and y, in N.
  double obstacle_force_n[2];
  // By how much the laws of contact were broken at worst in the last advance, in m/s.
  double contact_residual_m_s;
} IlonState;

// A wheel and its contact with the ground. Forces, slip and place are means over the last advance.
typedef struct {
  // Angle about the wheel's axis since the start, in radians, not wrapped.
  double angle_rad;
  // Rate about the wheel's axis, in rad/s.
  double rate_rad_s;
  // What its motor put on it, in N m: the mean over the last advance.
  double torque_n_m;
  // Height of the wheel's centre above the floor's plane, in metres.
  double hub_height_m;
  // The load: the ground's normal force, in N.
  double normal_force_n;
  // The ground's tangential force on the wheel, in the body frame's x and y, in N.
  double force_in_body_n[2];
  // Slip: the velocity of the rollers' surface over the ground, in the body frame's x and y, in m/s.
  double slip_in_body_m_s[2];
  // Where it touches, in the body frame, in metres.
  double place_in_body_m[3];
  // Coulomb's coefficient of friction under the roller that presses hardest.
  double friction;
  // Power that sliding turned into heat in the last physics step, in W.
  double slip_power_w;
  // Which roller presses hardest, at the end of the last advance.
  uint32_t roller;
  // 1 where any roller presses on the ground, 0 where none does.
  uint32_t touching;
} IlonWheel;

// A joint between bodies of the robot: a rocker, a sprung wheel. Numbers are in rad and N m of one that turns, in m and N of one that slides.
typedef struct {
  // How far it has moved from zero.
  double position;
  // Its rate.
  double rate;
  // What its spring, damper, friction and stops put on its body in the last physics step.
  double force;
} IlonJoint;

// Where energy is, and where it went since the start, in J. Motors and outside gave what all others have.
typedef struct {
  // Of all that moves, now.
  double kinetic_j;
  // In height and springs, now.
  double potential_j;
  // Work of the motors on the wheels.
  double motor_j;
  // What wrenches and payloads brought.
  double outside_j;
  // Heat of sliding.
  double slip_j;
  // What it took to bring rollers that came down up to their spin.
  double spin_up_j;
  // Heat of bearings and gears.
  double bearing_j;
  // What the normal forces took.
  double impact_j;
} IlonEnergies;

// A plant as it was at one moment. 0 is none.
typedef uint64_t IlonSnapshot;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Why the last call of this thread that failed did so, in UTF-8, or an empty text. It lies where it is until the next call of this thread
// fails, or the thread ends; never null.
const char *ilon_last_error(void);

// The version of the functions and structs of this library, to be compared with `ILON_ABI_VERSION` of the header.
uint32_t ilon_abi_version(void);

// The version of ilon, such as "0.1.0". Never null.
const char *ilon_version(void);

// Loads a scenario, a file in TOML, and stands its robot at the start, at rest.
//
// On success the handle is in `plant`; end it with `ilon_plant_free`. Whatever moves the robot in the scenario is not looked at: it is driven
// by the advances alone.
IlonStatus ilon_plant_load(const char *path,
                           IlonPlant *plant);

// Like `ilon_plant_load`, of a scenario's text. Its relative paths start from `folder`.
IlonStatus ilon_plant_parse(const char *toml, const char *folder, IlonPlant *plant);

// Ends a plant. Its handle is refused from now on; snapshots of it go on.
IlonStatus ilon_plant_free(IlonPlant plant);

// What stays as it is while the plant lives: counts, periods, limits.
IlonStatus ilon_plant_about(IlonPlant plant, IlonAbout *about);

// The name of a wheel's joint, with a closing zero, into a buffer of `size` bytes.
IlonStatus ilon_plant_wheel_name(IlonPlant plant, size_t wheel, char *buffer, size_t size);

// Begins anew, at rest: time zero, noise from `seed`, the robot at `pose`, or where that is null at the scenario's start. Wrench, payload and
// grip end, and friction is the scenario's.
IlonStatus ilon_plant_reset(IlonPlant plant,
                            uint64_t seed,
                            const IlonPose *pose);

// Lets the wheel loops follow rates in rad/s, one a wheel, for a period in seconds; with sampled wheel loops a whole
// number of physics steps.
IlonStatus ilon_plant_advance_rates(IlonPlant plant, const double *rates_rad_s, size_t count, double period_s);

// Lets the motors put torques in N m on the wheels, one a wheel and within their limits, for a period in seconds.
IlonStatus ilon_plant_advance_torques(IlonPlant plant, const double *torques_n_m, size_t count, double period_s);

// The robot as a whole, as it really is now.
IlonStatus ilon_plant_state(IlonPlant plant, IlonState *state);

// Its wheels with their contacts; `count` is that of `IlonAbout`.
IlonStatus ilon_plant_wheels(IlonPlant plant, IlonWheel *wheels, size_t count);

// Its joints between bodies; `count` is that of `IlonAbout`.
IlonStatus ilon_plant_joints(IlonPlant plant, IlonJoint *joints, size_t count);

// Where energy is, and where it went.
IlonStatus ilon_plant_energies(IlonPlant plant, IlonEnergies *energies);

// What the robot's sensors say now, with noise, delay and faults: its pose, and the rates in rad/s and angles in rad of its wheels. Any of the
// three may be null.
IlonStatus ilon_plant_observe(IlonPlant plant,
                              IlonPose *pose,
                              double *rates_rad_s,
                              double *angles_rad,
                              size_t count);

// The wheel rates in rad/s with which a robot whose wheels do not slip has a twist: vx and vy in m/s and omega in rad/s, in the body frame.
IlonStatus ilon_plant_rates_for_twist(IlonPlant plant, const double *twist, double *rates_rad_s, size_t count);

// Lets a force in N and a moment in N m act on the chassis from now on, both in the world frame: three numbers each, or null for none. The
// force acts at a place in the body frame in metres, or where that is null at the chassis's centre of mass. They act until the next call.
IlonStatus ilon_plant_set_wrench(IlonPlant plant,
                                 const double *force_in_world_n,
                                 const double *moment_in_world_n_m,
                                 const double *place_in_body_m);

// Puts a mass in kg on the robot, in place of the one put there before; 0 takes it off. It lies at a place in the body frame in metres, or
// where that is null at the chassis's centre of mass.
IlonStatus ilon_plant_set_payload(IlonPlant plant, double mass_kg, const double *place_in_body_m);

// Changes Coulomb's coefficient of friction of the floor from now on, but on its patches.
IlonStatus ilon_plant_set_friction(IlonPlant plant, double friction);

// Lets the ground lean from now on: gravity pulls along a direction in the world frame, three numbers; 0, 0, -1 is level ground.
IlonStatus ilon_plant_set_down(IlonPlant plant, const double *down_in_world);

// Lets the chassis bear from now on the articulated-body inertia of what your program moves, beside a wrench of what that puts on the chassis where
// it is not accelerated: 36 numbers, row by row, linear at the body frame's origin before angular, along the world's axes, in kg, kg m and
// kg m^2. Both engines then meet without a delay, whatever weighs more. All zeros end it.
IlonStatus ilon_plant_set_articulated_inertia(IlonPlant plant,
                                              const double *inertia);

// Lets the rollers of a wheel find a share of the ground's friction from now on, whatever lies beneath them; 1 for all of it.
IlonStatus ilon_plant_set_grip(IlonPlant plant, size_t wheel, double share);

// The plant as it is now, to come back to. On success the handle is in `snapshot`; end it with `ilon_snapshot_free`.
IlonStatus ilon_plant_snapshot(IlonPlant plant, IlonSnapshot *snapshot);

// Goes back to a snapshot of this plant, or of another of the same scenario: from there all is as it was, to the bit.
IlonStatus ilon_plant_restore(IlonPlant plant, IlonSnapshot snapshot);

// Ends a snapshot.
IlonStatus ilon_snapshot_free(IlonSnapshot snapshot);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ILON_H */
