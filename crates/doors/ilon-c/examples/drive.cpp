// Two robots on two threads, each a C++ object that frees itself; prints each one's position after
// a second.
//
//   c++ -std=c++17 -I crates/doors/ilon-c/include crates/doors/ilon-c/examples/drive.cpp -L target/release -lilon_c -Wl,-rpath,target/release -pthread
//   ./a.out assets/scenarios/mecanum4_lateral.toml
#include <cstdio>
#include <future>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ilon.h"

namespace {

void must(IlonStatus status) {
  if (status != ILON_STATUS_OK) throw std::runtime_error(ilon_last_error());
}

class Plant {
 public:
  explicit Plant(const std::string& scenario) { must(ilon_plant_load(scenario.c_str(), &handle_)); }
  ~Plant() { ilon_plant_free(handle_); }
  Plant(Plant&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;
  Plant& operator=(Plant&&) = delete;

  IlonAbout about() const {
    IlonAbout about;
    must(ilon_plant_about(handle_, &about));
    return about;
  }
  std::vector<double> rates_for_twist(double vx, double vy, double omega) const {
    const double twist[3] = {vx, vy, omega};
    std::vector<double> rates(about().wheel_count);
    must(ilon_plant_rates_for_twist(handle_, twist, rates.data(), rates.size()));
    return rates;
  }
  void advance(const std::vector<double>& rates, double period_s) {
    must(ilon_plant_advance_rates(handle_, rates.data(), rates.size(), period_s));
  }
  IlonState state() const {
    IlonState state;
    must(ilon_plant_state(handle_, &state));
    return state;
  }

 private:
  IlonPlant handle_ = 0;
};

IlonState drive(const std::string& scenario, double vx, double vy) {
  Plant plant(scenario);
  const auto rates = plant.rates_for_twist(vx, vy, 0.0);
  const double period_s = plant.about().control_dt_s;
  while (plant.state().time_s < 1.0 - 0.5 * period_s) plant.advance(rates, period_s);
  return plant.state();
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) throw std::runtime_error("give a scenario");
  auto ahead = std::async(std::launch::async, drive, argv[1], 0.3, 0.0);
  auto left = std::async(std::launch::async, drive, argv[1], 0.0, 0.3);
  for (const auto& state : {ahead.get(), left.get()}) {
    std::printf("%.17g %.17g %.17g\n", state.position_m[0], state.position_m[1], state.heading_rad);
  }
  return 0;
} catch (const std::exception& fault) {
  std::fprintf(stderr, "%s\n", fault.what());
  return 2;
}
