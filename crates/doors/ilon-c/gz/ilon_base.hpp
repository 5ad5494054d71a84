// ilon's robot as the base of a model in an engine that moves bodies by velocities. This file
// depends on no engine.
//
// In each step of the engine, `advance` takes the pose and motion of the engine's base, and returns
// the velocity that the engine shall set on it before it continues. The later change of that
// velocity by joints and contacts is the effect of the rest of the scene on the base: the base's
// inertia in the engine times that change is an impulse, which ilon's robot receives in the next
// step. A base that is heavier in the engine is moved off less; its mass there has no other
// meaning.
//
// A delay of one step would be unstable if the scene weighs more than the robot. So ilon solves its
// step with the scene's inertia among its own masses (`ilon_plant_set_articulated_inertia`), and
// its effect in the last step is added to the wrench. Any inertia of more than half of the scene's
// is stable; that of the model's links as one rigid body is.
//
// Right-handed frames, x forward, y left, z up; vectors in the world frame unless stated otherwise;
// SI units.
#pragma once

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "ilon.h"

namespace ilon {

using Vector = std::array<double, 3>;

inline Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector operator*(double s, const Vector& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// w, x, y, z, of length 1.
using Quaternion = std::array<double, 4>;

inline Quaternion conjugate(const Quaternion& q) { return {q[0], -q[1], -q[2], -q[3]}; }
inline Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}
inline Vector turned(const Quaternion& q, const Vector& v) {
  const Quaternion r = q * Quaternion{0.0, v[0], v[1], v[2]} * conjugate(q);
  return {r[1], r[2], r[3]};
}
// The axis times the angle of a rotation, the shorter way round.
inline Vector rotation_vector(Quaternion q) {
  if (q[0] < 0.0) q = {-q[0], -q[1], -q[2], -q[3]};
  const double sine = std::sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double scale = sine > 1e-12 ? 2.0 * std::atan2(sine, q[0]) / sine : 2.0;
  return {scale * q[1], scale * q[2], scale * q[3]};
}

// Pose and motion of a body: its origin, and its velocities.
struct Motion {
  Vector position{};
  Quaternion quaternion{1.0, 0.0, 0.0, 0.0};
  Vector linear{};
  Vector angular{};
};

// The inertia of a rigid body, or of several as one, about an origin: six rows of force and moment.
class Inertia {
 public:
  // Adds a body: its mass, its centre from the origin, and its inertia about its centre as three
  // rows.
  void add(double mass_kg, const Vector& center, const std::array<Vector, 3>& about_center) {
    for (int axis = 0; axis < 3; ++axis) {
      Vector unit{};
      unit[axis] = 1.0;
      // Columns for a unit of linear, then of angular acceleration.
      put(axis, mass_kg * unit, mass_kg * cross(center, unit));
      const Vector force = mass_kg * cross(unit, center);
      put(3 + axis, force, about_center[axis] + cross(center, force));
    }
  }
  std::pair<Vector, Vector> times(const Vector& linear, const Vector& angular) const {
    Vector force{}, moment{};
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        force[row] += rows_[6 * row + column] * linear[column] + rows_[6 * row + 3 + column] * angular[column];
        moment[row] += rows_[6 * (row + 3) + column] * linear[column] + rows_[6 * (row + 3) + 3 + column] * angular[column];
      }
    }
    return {force, moment};
  }
  const double* rows() const { return rows_.data(); }

 private:
  void put(int column, const Vector& force, const Vector& moment) {
    for (int row = 0; row < 3; ++row) {
      rows_[6 * row + column] += force[row];
      rows_[6 * (row + 3) + column] += moment[row];
    }
  }
  std::array<double, 36> rows_{};
};

class Base {
 public:
  // Loads a scenario: robot, floor, motors, wheel loops.
  explicit Base(const std::string& scenario) {
    must(ilon_plant_load(scenario.c_str(), &plant_));
    if (const auto status = ilon_plant_about(plant_, &about_); status != ILON_STATUS_OK) {
      ilon_plant_free(plant_);
      must(status);
    }
    rates_.assign(about_.wheel_count, 0.0);
  }
  ~Base() { ilon_plant_free(plant_); }
  Base(const Base&) = delete;
  Base& operator=(const Base&) = delete;

  // Sets the commanded wheel rates, in rad/s.
  void command_rates(const std::vector<double>& rates) {
    if (rates.size() != rates_.size()) {
      throw std::invalid_argument("the robot has " + std::to_string(rates_.size()) + " wheels, and " + std::to_string(rates.size()) + " rates were given");
    }
    rates_ = rates;
  }
  // Sets a commanded twist of the body frame, in m/s, m/s and rad/s.
  void command_twist(double ahead, double left, double turning) {
    const double twist[3] = {ahead, left, turning};
    must(ilon_plant_rates_for_twist(plant_, twist, rates_.data(), rates_.size()));
  }

  // Advances by a step of the engine, a whole number of ilon's steps. `now` is the engine's base,
  // `own` its inertia there, and `scene` that of the bodies attached to it, both about the base's
  // origin. Returns the linear and angular velocity for the engine to set.
  std::pair<Vector, Vector> advance(double step_s, const Motion& now, const Inertia& own, const Inertia& scene = {}) {
    const IlonState before = state();
    Vector force{}, moment{};
    if (went_on_) {
      std::tie(force, moment) = own.times(now.linear - set_.first, now.angular - set_.second);
      force = 1.0 / step_s * force;
      moment = 1.0 / step_s * moment;
      work_on_scene_j_ -= 0.5 * step_s * (dot(force, was_.linear + now.linear) + dot(moment, was_.angular + now.angular));
    }
    was_ = now;
    const auto [lent_force, lent_moment] = scene.times(linear_acceleration_, angular_acceleration_);
    force = force + lent_force;
    moment = moment + lent_moment;
    const Vector origin{};
    must(ilon_plant_set_articulated_inertia(plant_, scene.rows()));
    must(ilon_plant_set_wrench(plant_, force.data(), moment.data(), origin.data()));
    must(ilon_plant_advance_rates(plant_, rates_.data(), rates_.size(), step_s));
    const IlonState after = state();
    const Motion from = motion(before), to = motion(after);
    linear_acceleration_ = 1.0 / step_s * (to.linear - from.linear);
    angular_acceleration_ = 1.0 / step_s * (to.angular - from.angular);
    went_on_ = true;
    // To the pose of ilon's robot, whatever the engine did to its base.
    set_ = {1.0 / step_s * (to.position - now.position), 1.0 / step_s * rotation_vector(to.quaternion * conjugate(now.quaternion))};
    return set_;
  }

  // Pose and motion of ilon's robot.
  Motion motion() const { return motion(state()); }
  // Work of the base on the scene since the start, in J, by the engine's own velocities.
  double work_on_scene_j() const { return work_on_scene_j_; }
  const IlonAbout& about() const { return about_; }
  IlonPlant plant() const { return plant_; }

  // Restarts at the place of the engine's base: x, y and heading.
  void reset(double x_m, double y_m, double heading_rad) {
    const IlonPose pose{x_m, y_m, heading_rad};
    must(ilon_plant_reset(plant_, about_.seed, &pose));
    went_on_ = false;
    linear_acceleration_ = angular_acceleration_ = {};
    work_on_scene_j_ = 0.0;
  }

 private:
  static void must(IlonStatus status) {
    if (status != ILON_STATUS_OK) throw std::runtime_error(ilon_last_error());
  }
  static double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  IlonState state() const {
    IlonState state;
    must(ilon_plant_state(plant_, &state));
    return state;
  }
  static Motion motion(const IlonState& state) {
    Motion motion;
    for (int axis = 0; axis < 3; ++axis) motion.position[axis] = state.position_m[axis];
    for (int part = 0; part < 4; ++part) motion.quaternion[part] = state.quaternion_wxyz[part];
    const auto in_world = [&](const double* v) { return turned(motion.quaternion, {v[0], v[1], v[2]}); };
    motion.linear = in_world(state.velocity_in_body_m_s);
    motion.angular = in_world(state.angular_in_body_rad_s);
    return motion;
  }

  IlonPlant plant_ = 0;
  IlonAbout about_{};
  std::vector<double> rates_;
  std::pair<Vector, Vector> set_{};
  // The engine's base at the start of the last step.
  Motion was_{};
  Vector linear_acceleration_{}, angular_acceleration_{};
  bool went_on_ = false;
  double work_on_scene_j_ = 0.0;
};

}  // namespace ilon
