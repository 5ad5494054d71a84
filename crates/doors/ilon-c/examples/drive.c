/* Drives a robot to the left while another simulator pushes and loads it; prints its position after each control period.
 *
 *   cc -I crates/doors/ilon-c/include crates/doors/ilon-c/examples/drive.c -L target/release -lilon_c -Wl,-rpath,target/release -o drive
 *   ./drive assets/scenarios/mecanum4_lateral.toml
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "ilon.h"

/* Ends the program if a call failed. */
static void must(IlonStatus status, const char *call) {
  if (status != ILON_STATUS_OK) {
    fprintf(stderr, "%s: code %d: %s\n", call, (int)status, ilon_last_error());
    exit(2);
  }
}
#define MUST(call) must((call), #call)

static void print_state(IlonPlant plant) {
  IlonState state;
  MUST(ilon_plant_state(plant, &state));
  printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", state.time_s, state.position_m[0], state.position_m[1], state.heading_rad,
         state.velocity_in_body_m_s[0], state.velocity_in_body_m_s[1], state.angular_in_body_rad_s[2]);
}

/* One second of driving while a spring pulls the robot back to its start, and sand fills a bucket at its front. */
static void drive(IlonPlant plant, const IlonAbout *about, const double *rates) {
  const double front[3] = {0.1, 0.0, 0.1};
  for (int period = 0; period < 50; ++period) {
    IlonState state;
    MUST(ilon_plant_state(plant, &state));
    const double force[3] = {-4.0 * state.position_m[0], -4.0 * state.position_m[1], 0.0};
    const double moment[3] = {0.0, 0.0, -0.5 * state.heading_rad};
    MUST(ilon_plant_set_wrench(plant, force, moment, NULL));
    MUST(ilon_plant_set_payload(plant, 0.02 * period, front));
    MUST(ilon_plant_advance_rates(plant, rates, about->wheel_count, about->control_dt_s));
    print_state(plant);
  }
}

int main(int argc, char **argv) {
  if (argc != 2) {
    fprintf(stderr, "give a scenario\n");
    return 2;
  }
  if (ilon_abi_version() != ILON_ABI_VERSION) {
    fprintf(stderr, "the library is of another version than the header\n");
    return 2;
  }
  IlonPlant plant;
  MUST(ilon_plant_load(argv[1], &plant));
  IlonAbout about;
  MUST(ilon_plant_about(plant, &about));
  double *rates = calloc(about.wheel_count, sizeof *rates);
  const double twist[3] = {0.0, 0.3, 0.0};
  MUST(ilon_plant_rates_for_twist(plant, twist, rates, about.wheel_count));

  /* The same second twice, bit for bit. */
  IlonSnapshot start;
  MUST(ilon_plant_snapshot(plant, &start));
  drive(plant, &about, rates);
  MUST(ilon_plant_restore(plant, start));
  drive(plant, &about, rates);
  MUST(ilon_snapshot_free(start));

  IlonWheel *wheels = calloc(about.wheel_count, sizeof *wheels);
  MUST(ilon_plant_wheels(plant, wheels, about.wheel_count));
  for (uint32_t wheel = 0; wheel < about.wheel_count; ++wheel) {
    char name[64];
    MUST(ilon_plant_wheel_name(plant, wheel, name, sizeof name));
    fprintf(stderr, "%-12s carries %6.2f N and slips at %.4f m/s\n", name, wheels[wheel].normal_force_n,
            hypot(wheels[wheel].slip_in_body_m_s[0], wheels[wheel].slip_in_body_m_s[1]));
  }
  free(wheels);
  free(rates);

  MUST(ilon_plant_free(plant));
  if (ilon_plant_free(plant) != ILON_STATUS_HANDLE) return 2;
  fprintf(stderr, "freed twice: %s\n", ilon_last_error());
  return 0;
}
