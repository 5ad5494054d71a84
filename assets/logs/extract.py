"""Makes the extracts in this folder from the published data sets, whose places are given: OPTIODOM ROBOTINO CONVENTIONAL."""

import csv
import math
import pathlib
import sys

here = pathlib.Path(__file__).parent


def write(path, header, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="\n") as file:
        file.write(",".join(header) + "\n")
        for row in rows:
            file.write(",".join(row) + "\n")


def plain(value, digits):
    """A number without zeros at its end."""
    text = f"{value:.{digits}f}"
    if digits:
        text = text.rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def optiodom(source, target, wheels, counts_per_unit, every, until_s=math.inf):
    """Keeps every so many rows: time, pose, and the counts of the wheels summed from the beginning."""
    rows, counts = [], [0.0] * wheels
    with open(source, newline="") as file:
        for index, row in enumerate(csv.reader(file)):
            numbers = [float(cell) for cell in row]
            counts = [a + b for a, b in zip(counts, numbers[4:])]
            if index % every == 0 and numbers[0] <= until_s:
                rows.append(
                    [plain(numbers[0], 3), plain(1e3 * numbers[1], 2), plain(1e3 * numbers[2], 2), plain(1e3 * numbers[3], 1)]
                    + [plain(count * counts_per_unit, 0) for count in counts]
                )
    header = ["t_s", "x_mm", "y_mm", "heading_mrad"] + [f"ticks_{wheel + 1}" for wheel in range(wheels)]
    write(target, header, rows)


def differential(source, target, every):
    """Keeps every so many rows, as a log to play back: the angle of each wheel and the pose. The right wheel comes first."""
    rows, counts = [], [0.0] * 2
    with open(source, newline="") as file:
        for index, row in enumerate(csv.reader(file)):
            numbers = [float(cell) for cell in row]
            counts = [a + b for a, b in zip(counts, numbers[4:])]
            if index % every == 0:
                rows.append(
                    [plain(numbers[0], 3)]
                    + [plain(360 * count / (64 * 43.7), 2) for count in counts]
                    + [plain(numbers[1], 5), plain(numbers[2], 5), plain(math.degrees(numbers[3]), 2)]
                )
    header = ["t_s", "right_angle_deg", "left_angle_deg", "measured_x_m", "measured_y_m", "measured_heading_deg"]
    write(target, header, rows)


def tricycle(source, target, every):
    """Keeps every so many rows: time, the wheel's angle by its ticks (1600 a turn), the angle of its steering, and the tracker's pose."""
    rows, turned = [], 0.0
    with open(source, newline="") as file:
        for index, row in enumerate(csv.reader(file)):
            t_s, x, y, heading, ticks, steering = map(float, row)
            turned += 360 * ticks / 1600
            if index % every == 0:
                degrees = [plain(math.degrees(angle), 2) for angle in (steering, heading)]
                rows.append([plain(t_s, 2), plain(turned, 2), degrees[0], plain(x, 5), plain(y, 5), degrees[1]])
    header = ["t_s", "drive_angle_deg", "drive_steer_position_deg", "measured_x_m", "measured_y_m", "measured_heading_deg"]
    write(target, header, rows)


def robotino(source, target, every):
    """Keeps every so many rows: time and positions of the motors, the means of their currents since the row before, and the camera's pose."""
    rows, currents = [], []
    with open(source, newline="") as file:
        for index, row in enumerate(csv.reader(file, delimiter=";")):
            if index < 3:
                continue
            x = [float(cell) for cell in row if cell]
            currents.append(x[13:16])
            if (index - 3) % every == 0:
                means = [sum(column) / len(currents) for column in zip(*currents)]
                rows.append(
                    [plain(x[0], 1)] + [plain(count, 0) for count in x[7:10]] + [plain(mean, 3) for mean in means]
                    + [plain(x[19], 2), plain(x[20], 2), plain(x[21], 2)]
                )
                currents = []
    header = ["t_ms", "ticks_1", "ticks_2", "ticks_3", "current_1_a", "current_2_a", "current_3_a", "x_px", "y_px", "angle_deg"]
    write(target, header, rows)


def main():
    opti, robo, conv = map(pathlib.Path, sys.argv[1:])
    for series, short, every, until_s in [
        ("mecanum_circles_sep", "circles_sep", 4, math.inf),
        ("mecanum_circles_dec", "circles_dec", 4, 40.0),
        ("mecanum_squares_sep", "squares_sep", 4, math.inf),
        ("omni3_squares", "omni3_squares", 2, math.inf),
    ]:
        for source in sorted((opti / series).glob("*run-[0-9][0-9].csv")):
            if series == "mecanum_squares_sep" and source.stem[-2:] not in ("01", "07"):
                continue
            number = source.stem[-2:]
            mecanum = series.startswith("mecanum")
            # Increments of the mecanum robot are in turns of 11520 counts, those of the other in ticks.
            optiodom(source, here / "optiodom" / f"{short}_{number}.csv", 4 if mecanum else 3, 11520 if mecanum else 1, every, until_s)
    for floor in ("table", "brown", "gray"):
        for number in range(0, 72, 3):
            source = robo / floor / f"exp{number:02}.csv"
            if source.exists():
                robotino(source, here / "robotino" / f"{floor}_{5 * number:03}.csv", 5)
    for series, short, runs in [
        ("diff_circular_231220200121", "differential_circles", (1, 2, 4, 5)),
        ("diff_square_231220200029", "differential_squares", (1, 4)),
    ]:
        for number in runs:
            source = conv / series / f"run-{number:02}.csv"
            differential(source, here / "optiodom" / f"{short}_{number:02}.csv", 4)
    for series, short in [("tricyc_circular_140120211415", "tricycle_circles"), ("tricyc_square_140120211430", "tricycle_squares")]:
        for number in (1, 2):
            source = conv / series / f"run-{number:02}.csv"
            tricycle(source, here / "optiodom" / f"{short}_{number:02}.csv", 4)


main()
