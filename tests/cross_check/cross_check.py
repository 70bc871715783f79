"""Compares `utm-sky map` with sasktran2 on the optics that `utm-sky optics` exports.

See README.md. Prints one line a case and one for all; `--speed` compares the time of 75 maps.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

import solver

ROOT = Path(__file__).resolve().parents[2]

# One value for all wavelengths, for both.
DEPOLARIZATION = 0.0283


@dataclass
class Case:
    altitude_km: float
    turbidity: float
    sun_zenith_deg: float
    albedo: float
    view: str = "sky"


# Altitudes, turbidities and suns that are no node of a shipped table.
CASES = [
    Case(0.0, 1.0, 52.0, 0.2),
    Case(0.0, 2.3, 34.0, 0.2),
    Case(0.0, 5.2, 67.0, 0.2),
    Case(0.0, 1.7, 83.5, 0.1),
    Case(1.3, 3.1, 71.0, 0.2),
    Case(3.4, 1.4, 17.0, 0.6),
    Case(4.6, 6.5, 78.0, 0.2),
    Case(9.2, 2.6, 58.0, 0.2),
    Case(15.5, 1.2, 81.0, 0.0),
    Case(26.0, 4.3, 43.0, 0.2),
    Case(0.0, 1.3, 88.6, 0.2),
    Case(2.2, 3.6, 89.4, 0.2),
    Case(9.2, 1.5, 91.3, 0.2),
    Case(22.0, 2.2, 90.6, 0.2),
    Case(0.6, 3.0, 93.6, 0.2),
    Case(30.0, 2.0, 25.0, 0.2),
    Case(3.0, 5.0, 92.0, 0.2, "ground"),
    Case(12.0, 2.4, 64.0, 0.5, "ground"),
    Case(99.9, 2.0, 50.0, 0.2, "space"),
    Case(99.9, 2.0, 92.0, 0.2, "space"),
]

QUICK_CASES = [CASES[k] for k in (1, 4, 7, 9, 10, 16)]

ZENITH_DEG = [10, 25, 40, 52, 63, 72, 77, 80, 82, 84, 86, 87.5, 88.7, 89.6]
AZIMUTH_DEG = [0, 12, 30, 60, 95, 135, 180]

# What the sun's surroundings hide from every comparison of the project.
SUN_EXCLUSION_DEG = 5.0


# Below the horizon; and from the top of the air: tangent heights of the limb [km], then the ground.
GROUND_ZENITH_DEG = [93, 95, 98, 105, 120, 140, 165, 180]
LIMB_KM = [50, 35, 22, 12, 5, 1]
SPACE_GROUND_DEG = [101, 106, 115, 130, 150, 180]


def directions(case):
    if case.view == "sky":
        rings = [(z, a) for z in ZENITH_DEG for a in AZIMUTH_DEG]
        return np.array([(0.0, 0.0), *rings])
    if case.view == "ground":
        zenith = GROUND_ZENITH_DEG
    else:
        earth = solver.EARTH_RADIUS_M / 1000.0
        sine = (earth + np.array(LIMB_KM)) / (earth + case.altitude_km)
        zenith = [*(180.0 - np.degrees(np.arcsin(sine))), *SPACE_GROUND_DEG]
    return np.array([(z, a) for z in zenith for a in (12, 60, 95, 135, 180)])


def report_directions():
    rings = [(z, a) for z in range(10, 91, 10) for a in range(0, 360, 12)]
    return np.array([(0.0, 0.0), *rings], float)


def angle_from_sun_deg(where, sun_deg):
    zenith, azimuth = np.radians(where).T
    sun = np.radians(sun_deg)
    cosine = np.cos(zenith) * np.cos(sun) + np.sin(zenith) * np.sin(sun) * np.cos(azimuth)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def luminance_weights(wavelength_nm, irradiance):
    """Weights that turn radiance over irradiance into luminance, up to a factor."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    y = np.interp(wavelength_nm, observer.wavelengths, observer.values[:, 1])
    width = np.gradient(wavelength_nm) if len(wavelength_nm) > 1 else 1.0
    return y * width * irradiance


class Program:
    """The program under test, in a directory of its own."""

    def __init__(self, path, directory):
        self.path = Path(path).resolve()
        self.directory = Path(directory)

    def call(self, *words):
        command = [str(self.path), *map(str, words)]
        done = subprocess.run(command, cwd=self.directory, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)}\n{done.stderr}")

    def optics(self, haze, wavelength_nm=None, step_nm=20):
        """Exports optics and sun, thinned to some wavelengths."""
        step = 10 if wavelength_nm else step_nm
        self.call(
            "optics", *haze, "--wavelength-step-nm", step,
            "--out", "optics.csv", "--solar", "solar.csv",
        )  # fmt: skip
        rows = pd.read_csv(self.directory / "optics.csv")
        if wavelength_nm:
            rows = rows[rows.wavelength_nm.isin(wavelength_nm)]
            rows.to_csv(self.directory / "optics.csv", index=False)
        solar = pd.read_csv(self.directory / "solar.csv").set_index("wavelength_nm")
        air = solver.Air.read(self.directory / "optics.csv", DEPOLARIZATION)
        return air, solar.loc[air.wavelength_nm, "irradiance_w_m2_nm"].to_numpy()

    def map(self, case, where):
        """Spectral radiance by direction and wavelength."""
        columns = ["view_zenith_deg", "relative_azimuth_deg"]
        pd.DataFrame(where, columns=columns).to_csv(self.directory / "where.csv", index=False)
        self.call(
            "map", "--optics", "optics.csv", "--solar", "solar.csv",
            "--altitude-km", case.altitude_km, "--sun-zenith-deg", case.sun_zenith_deg,
            "--albedo", case.albedo, "--depolarization", DEPOLARIZATION,
            "--directions", "where.csv", "--out", "map.csv",
        )  # fmt: skip
        rows = pd.read_csv(self.directory / "map.csv")
        return rows.radiance_w_m2_sr_nm.to_numpy().reshape(len(where), -1)


def judge_azimuth(map_, where, sun_deg):
    """The sun's side must be the bright one: azimuths are easily mixed up."""
    ring = where[:, 0] == 63
    ahead = map_[ring & (where[:, 1] == 12)].mean()
    behind = map_[ring & (where[:, 1] == 135)].mean()
    if sun_deg > 50 and ahead <= behind:
        sys.exit("the sky is not brighter on the sun's side")


def differences(program, cases, wavelength_nm, options):
    print(
        "Difference of `utm-sky map` from sasktran2, luminance [%]; "
        f"view zenith 80 to 90 deg apart; {SUN_EXCLUSION_DEG:g} deg around the sun left out"
    )
    head = "altitude turbidity  sun albedo    bias median    p95    max   80-90 median    p95   seconds"
    print(head)
    everything, horizon, low_sun = [], [], []
    others = {"ground": [], "space": []}
    for case in cases:
        air, irradiance = program.optics(
            ["--turbidity", case.turbidity], wavelength_nm, options.step_nm
        )
        where = directions(case)
        where = where[angle_from_sun_deg(where, case.sun_zenith_deg) > SUN_EXCLUSION_DEG]
        ours = program.map(case, where)
        begin = time.perf_counter()
        theirs = irradiance * solver.radiance(
            air,
            case.altitude_km,
            case.sun_zenith_deg,
            case.albedo,
            where,
            options.threads,
            options.quick,
        )
        seconds = time.perf_counter() - begin
        if case.view == "sky":
            for map_ in (ours, theirs):
                judge_azimuth(map_, where, case.sun_zenith_deg)
        weight = luminance_weights(air.wavelength_nm, 1.0)
        signed = 100 * ((ours @ weight) / (theirs @ weight) - 1)
        error = np.abs(signed)
        band = error[where[:, 0] >= 80] if case.view == "sky" else error
        print(
            f"{case.altitude_km:8g} {case.turbidity:9g} {case.sun_zenith_deg:4g} {case.albedo:6g} "
            f"{signed.mean():7.2f} {np.median(error):6.2f} {np.percentile(error, 95):6.2f} "
            f"{error.max():6.2f} {np.median(band):14.2f} {np.percentile(band, 95):6.2f} {seconds:9.1f}",
            flush=True,
        )
        if case.view != "sky":
            others[case.view].append(error)
        elif case.sun_zenith_deg >= 88:
            low_sun.append(error)
        else:
            everything.append(error)
            horizon.append(band)
    print()
    for name, parts in [
        ("sun below 88 deg, all directions", everything),
        ("sun below 88 deg, view zenith 80 to 90 deg", horizon),
        ("sun at 88 deg and lower, all directions", low_sun),
        ("below the horizon", others["ground"]),
        ("from the top of the air, limb and ground", others["space"]),
    ]:
        if parts:
            all_ = np.concatenate(parts)
            print(
                f"{name}: median {np.median(all_):.2f} %, 95th percentile "
                f"{np.percentile(all_, 95):.2f} %, largest {all_.max():.2f} %"
            )


def speed(program, threads):
    """75 maps of 271 directions and 41 wavelengths: criterion's figure against the fast mode."""
    environment = {**os.environ, "RAYON_NUM_THREADS": str(threads)}
    # Criterion writes to target/criterion, wherever that target is.
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    bench = ["cargo", "bench", "--locked", "-p", "sky-sim", "--bench", "transport", "--", "75 maps"]
    subprocess.run(bench, cwd=ROOT, env=environment, check=True, stdout=subprocess.DEVNULL)
    found = sorted(target.glob("criterion/75 maps*/new/estimates.json"))
    if not found:
        sys.exit(f"{target}/criterion: expected the bench's estimates, found none")
    ours = json.loads(found[0].read_text())["mean"]["point_estimate"] * 1e-9
    theirs = 0.0
    for depth in (0.0, 0.5, 1.0):
        air, _ = program.optics(["--aod500", depth], step_nm=10)
        for sun_deg in (90.0, 45.0, 0.0, 45.0, 90.0):
            begin = time.perf_counter()
            solver.fast_maps(air, [0.001, 6, 12, 20, 30], sun_deg, 0.2, report_directions(), threads)
            theirs += time.perf_counter() - begin
    print(
        f"75 maps x 271 directions x 41 wavelengths, {threads} threads: transport {ours:.2f} s; "
        f"sasktran2, discrete ordinates, 16 streams {theirs:.1f} s; ratio {theirs / ours:.1f}"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--utm-sky", required=True, help="the program")
    parser.add_argument("--quick", action="store_true", help="five cases, three wavelengths, draft")
    parser.add_argument("--case", type=int, nargs="*", help="only these, counted from 0")
    parser.add_argument("--wavelength-nm", type=float, nargs="*", help="only these, of every 10 nm")
    parser.add_argument("--step-nm", type=int, default=20, help="of all wavelengths; 20 without")
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--speed", action="store_true", help="compare times instead")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        program = Program(options.utm_sky, directory)
        if options.speed:
            speed(program, options.threads)
            return
        cases, wavelength_nm = CASES, options.wavelength_nm
        if options.quick:
            cases, wavelength_nm = QUICK_CASES, wavelength_nm or [450.0, 550.0, 650.0]
        if options.case:
            cases = [CASES[k] for k in options.case]
        differences(program, cases, wavelength_nm, options)


if __name__ == "__main__":
    main()
