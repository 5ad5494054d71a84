// The base of gz/ilon_base.hpp in a minimal engine: bodies whose velocities are integrated by
// semi-implicit steps, with a mass welded to the base. Prints x, y and z of ilon alone with that
// mass as its payload and of both engines, the distance between the engine's base and ilon's, and
// energies.
#include <cstdio>
#include <cstdlib>

#include "ilon_base.hpp"

using namespace ilon;

namespace {

constexpr double kGravity = 9.81;
constexpr double kBaseKg = 1e4;

// A base moved by velocities, and a body welded to its origin, which falls without it.
struct Engine {
  Motion base;
  double scene_kg;
  Vector scene_velocity{};

  void step(const std::pair<Vector, Vector>& set, double step_s) {
    // The weld: both share their momentum.
    scene_velocity[2] -= kGravity * step_s;
    const double whole_kg = kBaseKg + scene_kg;
    base.linear = kBaseKg / whole_kg * set.first + scene_kg / whole_kg * scene_velocity;
    scene_velocity = base.linear;
    base.angular = set.second;
    base.position = base.position + step_s * base.linear;
    const Vector half = 0.5 * step_s * base.angular;
    const double angle = std::sqrt(half[0] * half[0] + half[1] * half[1] + half[2] * half[2]);
    const double scale = angle > 1e-12 ? std::sin(angle) / angle : 1.0;
    base.quaternion = Quaternion{std::cos(angle), scale * half[0], scale * half[1], scale * half[2]} * base.quaternion;
  }
};

void must(IlonStatus status) {
  if (status != ILON_STATUS_OK) throw std::runtime_error(ilon_last_error());
}

Inertia ball(double mass_kg) {
  Inertia inertia;
  inertia.add(mass_kg, {}, {Vector{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}});
  return inertia;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) throw std::runtime_error("give a scenario, a mass in kg and the share of it that is said");
  const double scene_kg = std::atof(argv[2]), said = std::atof(argv[3]);
  Base coupled(argv[1]), alone(argv[1]);
  const double step_s = coupled.about().physics_dt_s;
  const Vector origin{};
  must(ilon_plant_set_payload(alone.plant(), scene_kg, origin.data()));
  Engine engine{coupled.motion(), scene_kg, {}};
  Inertia own = ball(kBaseKg), scene, nothing;
  // A point mass, as the payload is.
  scene.add(said * scene_kg, {}, {});
  double apart_m = 0.0;
  const int steps = static_cast<int>(1.0 / step_s + 0.5);
  for (int step = 0; step < steps; ++step) {
    for (Base* base : {&coupled, &alone}) base->command_twist(0.4, step > steps / 2 ? 0.3 : 0.0, 0.5);
    alone.advance(step_s, alone.motion(), nothing);
    engine.step(coupled.advance(step_s, engine.base, own, scene), step_s);
    const Vector off = engine.base.position - coupled.motion().position;
    for (const double axis : off) apart_m = std::fmax(apart_m, std::fabs(axis));
  }
  for (const auto& motion : {alone.motion(), coupled.motion()}) {
    const Vector turned = rotation_vector(motion.quaternion);
    std::printf("%.12g %.12g %.12g %.12g\n", motion.position[0], motion.position[1], motion.position[2], turned[2]);
  }
  const Vector& v = engine.scene_velocity;
  const double kinetic_j = 0.5 * scene_kg * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  // The effect of the last step is known in the next.
  coupled.advance(step_s, engine.base, own, scene);
  std::printf("%.12g %.12g %.12g 0\n", apart_m, coupled.work_on_scene_j(), kinetic_j);

  // Invalid calls are refused with a message, and the base continues.
  int refused = 0;
  const auto refuses = [&](auto act) {
    try {
      act();
    } catch (const std::exception& fault) {
      std::fprintf(stderr, "%s\n", fault.what());
      ++refused;
    }
  };
  refuses([&] { coupled.advance(-step_s, engine.base, own, scene); });
  refuses([&] { coupled.command_rates({1.0}); });
  refuses([&] { coupled.command_twist(NAN, 0.0, 0.0); });
  refuses([] { Base("nowhere.toml"); });
  engine.base.linear[0] = NAN;
  refuses([&] { coupled.advance(step_s, engine.base, own, scene); });
  coupled.reset(1.0, 2.0, 0.5);
  const Vector at = coupled.motion().position;
  std::printf("%d %.12g %.12g 0\n", refused, at[0], at[1]);
  return 0;
} catch (const std::exception& fault) {
  std::fprintf(stderr, "%s\n", fault.what());
  return 2;
}
