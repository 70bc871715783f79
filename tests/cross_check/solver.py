"""Clear-sky radiance by the public radiative-transfer package sasktran2, from a table of optics.

Everything is per unit of solar irradiance. Light scattered once comes from sasktran2's exact source in
one dimension, on levels that are very fine around the observer; light scattered more often from its
successive orders in two dimensions, in the plane of the sun, where the Earth's shadow is respected.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import sasktran2 as sk

EARTH_RADIUS_M = 6_371_000.0

COLUMNS = {
    "rayleigh": "rayleigh_scattering_per_km",
    "gas": "gas_absorption_per_km",
    "scattering": "aerosol_scattering_per_km",
    "absorption": "aerosol_absorption_per_km",
    "g": "aerosol_g",
    "g2": "aerosol_g2",
    "share": "aerosol_g_weight",
}


@dataclass
class Air:
    """Optics by level and wavelength, linear between levels; coefficients per km."""

    level_km: np.ndarray
    wavelength_nm: np.ndarray
    part: dict
    depolarization: float

    @classmethod
    def read(cls, path, depolarization):
        rows = pd.read_csv(path)
        part = {
            name: rows.pivot(index="altitude_km", columns="wavelength_nm", values=column)
            for name, column in COLUMNS.items()
        }
        grid = part["gas"]
        return cls(
            grid.index.to_numpy(float),
            grid.columns.to_numpy(float),
            {name: table.to_numpy(float) for name, table in part.items()},
            depolarization,
        )

    def at(self, level_km):
        """The same air on other levels."""

        def column(values):
            return np.interp(level_km, self.level_km, values)

        part = {name: np.apply_along_axis(column, 0, table) for name, table in self.part.items()}
        return Air(np.asarray(level_km), self.wavelength_nm, part, self.depolarization)

    def only(self, wavelengths):
        part = {name: table[:, wavelengths] for name, table in self.part.items()}
        return Air(self.level_km, self.wavelength_nm[wavelengths], part, self.depolarization)

    def legendre_terms(self, least):
        """Terms after which the phase function's series adds less than a part in ten thousand."""
        g = max(np.abs(self.part["g"]).max(), np.abs(self.part["g2"]).max())
        terms = least
        while terms < 512 and (2 * terms + 1) * g**terms > 1e-4 * (1 - g):
            terms += 16
        return terms

    def pour_into(self, atmosphere, terms, albedo, copies=1):
        """Writes the optics into sasktran2's arrays, `copies` times side by side."""
        p = {name: np.tile(table, (copies, 1)) for name, table in self.part.items()}
        scattering = p["rayleigh"] + p["scattering"]
        extinction = scattering + p["gas"] + p["absorption"]
        tiny = np.finfo(float).tiny
        molecules = np.where(scattering > 0, p["rayleigh"] / np.maximum(scattering, tiny), 1.0)
        store = atmosphere.storage
        store.total_extinction[:] = extinction / 1000.0
        store.ssa[:] = np.clip(scattering / np.maximum(extinction, tiny), 0.0, 1.0)
        store.solar_irradiance[:] = 1.0
        order = np.arange(terms)[:, None, None]
        aerosol = p["share"] * p["g"] ** order + (1.0 - p["share"]) * p["g2"] ** order
        series = (2 * order + 1) * (1.0 - molecules) * aerosol
        series[0] += molecules
        series[2] += molecules * (1.0 - self.depolarization) / (2.0 + self.depolarization)
        atmosphere.leg_coeff.a1[:terms] = series
        atmosphere.surface.albedo[:] = albedo


def merged(*groups, top):
    """Ascending levels from 0 to the top, none closer than 2 mm to the next."""
    level = np.unique(np.clip(np.concatenate(groups), 0.0, top))
    kept = [0.0]
    for z in level:
        if z > kept[-1] + 2e-6:
            kept.append(z)
    kept[-1] = top
    return np.array(kept)


def steps(*pieces):
    """Levels from pieces (from, to, step)."""
    return np.concatenate([np.arange(a, b, d) for a, b, d in pieces])


def around(observer_km, growth):
    """Levels close to an observer: a level ray rises 8 cm in its first kilometer, so the distances
    begin at millimeters and grow by a factor."""
    distance = 2e-6 * growth ** np.arange(0, np.log(5e5) / np.log(growth))
    return np.concatenate([[observer_km], observer_km + distance, observer_km - distance])


def fine_levels(air, observer_km, sun_deg):
    """For light scattered once. The shadow's edge cuts layers when the sun is low."""
    thin = 3 if sun_deg > 88 else 1
    base = steps(
        (0, 0.5, 0.025),
        (0.5, 3, 0.05),
        (3, 6, 0.1 / thin),
        (6, 12, 0.2 / thin),
        (12, 30, 0.5 / thin),
        (30, 100, 1.0 / thin),
    )
    return merged(base, around(observer_km, 1.3), top=air.level_km[-1])


def coarse_levels(air, observers_km):
    """For light scattered more often. Coarser than 1 km above 30 km, the light comes out several
    percent too bright at the wavelengths that ozone absorbs."""
    base = steps((0, 1, 0.1), (1, 3, 0.125), (3, 8, 0.25), (8, 16, 0.5), (16, 60, 1.0), (60, 100, 5.0))
    near = [around(z, 2.0) for z in observers_km]
    return merged(base, [0.001, 0.01], *near, top=air.level_km[-1])


def rays(sun_deg, observers_km, directions):
    """The lines of sight; azimuth 0 faces the sun."""
    view = sk.ViewingGeometry()
    sun = np.cos(np.radians(sun_deg))
    for z in observers_km:
        for zenith, azimuth in np.radians(directions):
            view.add_ray(sk.SolarAnglesObserverLocation(sun, azimuth, np.cos(zenith), z * 1000.0))
    return view


def shells(sun_deg, level_km, kind=None):
    """One-dimensional geometry."""
    return sk.Geometry1D(
        np.cos(np.radians(sun_deg)),
        0.0,
        EARTH_RADIUS_M,
        level_km * 1000.0,
        sk.InterpolationMethod.LinearInterpolation,
        kind or sk.GeometryType.Spherical,
    )


def run(config, geometry, view, air, terms, albedo, copies=1):
    """Radiance by ray and wavelength."""
    atmosphere = sk.Atmosphere(
        geometry, config, numwavel=len(air.wavelength_nm), calculate_derivatives=False
    )
    air.pour_into(atmosphere, terms, albedo, copies)
    answer = sk.Engine(config, geometry, view).calculate_radiance(atmosphere)
    return answer["radiance"].values[:, :, 0].T


def scattered_once(air, observer_km, sun_deg, albedo, directions, threads):
    config = sk.Config()
    config.num_threads = threads
    config.single_scatter_source = sk.SingleScatterSource.Exact
    config.multiple_scatter_source = sk.MultipleScatterSource.NoSource
    terms = air.legendre_terms(16)
    config.num_singlescatter_moments = terms
    fine = air.at(fine_levels(air, observer_km, sun_deg))
    geometry = shells(sun_deg, fine.level_km)
    # A few rays at a time: their paths to the sun take memory.
    parts = [
        run(config, geometry, rays(sun_deg, [observer_km], some), fine, terms, albedo)
        for some in np.array_split(directions, -(-len(directions) // 40))
    ]
    return np.concatenate(parts)


def sun_columns(sun_deg):
    """Places along the solar plane where the diffuse light is solved [rad from the observer]."""
    if sun_deg < 70:
        side = [0.07, 0.2]
    elif sun_deg < 86:
        side = [0.03, 0.07, 0.12, 0.2]
    else:
        side = [0.01, 0.02, 0.03, 0.04, 0.05, 0.065, 0.08, 0.1, 0.125, 0.16, 0.2]
    return np.array([*(-x for x in reversed(side)), 0.0, *side])


SOURCE_KM = np.concatenate(
    [
        [0.002, 0.02, 0.06, 0.12, 0.2, 0.3, 0.45, 0.6, 0.8],
        steps((1, 3, 0.3), (3, 12, 0.8), (12, 30, 2.0), (30, 60, 4.0)),
        [60.0, 70.0, 85.0],
    ]
)


def scattered_often(air, observer_km, sun_deg, albedo, directions, threads, draft):
    config = sk.Config()
    config.num_threads = threads
    config.single_scatter_source = sk.SingleScatterSource.NoSource
    config.multiple_scatter_source = sk.MultipleScatterSource.SuccessiveOrders
    config.num_streams = 32
    terms = air.legendre_terms(32)
    config.num_singlescatter_moments = terms
    # Numbers of Lebedev's quadratures; the first sets the time. A draft is up to 1 % off in haze.
    config.num_successive_orders_incoming = 110 if draft else 302 if sun_deg < 87 else 194
    config.num_successive_orders_outgoing = 302 if draft else 770
    config.num_successive_orders_iterations = 200
    config.successive_orders_relative_tolerance = 1e-5
    config.successive_orders_altitude_grid_m = SOURCE_KM * 1000.0
    columns = sun_columns(sun_deg)
    config.num_sza = len(columns)
    config.successive_orders_horizontal_angle_grid_radians = columns
    coarse = air.at(coarse_levels(air, [observer_km]))
    # The air is the same everywhere. These nodes lie beyond every ray; their number sets how finely
    # sasktran2 tabulates the sun's light.
    side = np.linspace(0.5, 1.5, 50)
    nodes = np.concatenate([-side[::-1], side])
    geometry = sk.Geometry2D(
        np.cos(np.radians(sun_deg)), 0.0, EARTH_RADIUS_M, coarse.level_km * 1000.0, nodes
    )
    view = rays(sun_deg, [observer_km], directions)
    engine = sk.Engine(config, geometry, view)
    parts = []
    for k in range(0, len(air.wavelength_nm), threads):
        some = coarse.only(slice(k, k + threads))
        atmosphere = sk.Atmosphere(
            geometry, config, numwavel=len(some.wavelength_nm), calculate_derivatives=False
        )
        some.pour_into(atmosphere, terms, albedo, copies=len(nodes))
        parts.append(engine.calculate_radiance(atmosphere)["radiance"].values[:, :, 0].T)
    return np.concatenate(parts, axis=1)


def radiance(air, observer_km, sun_deg, albedo, directions, threads, draft=False):
    """Radiance over solar irradiance [1/sr], by direction and wavelength."""
    scene = (air, max(observer_km, 0.001), sun_deg, albedo, np.asarray(directions, float), threads)
    return scattered_once(*scene) + np.maximum(scattered_often(*scene, draft), 0.0)


def fast_maps(air, observers_km, sun_deg, albedo, directions, threads, streams=16):
    """sasktran2's fast mode: discrete ordinates with a pseudo-spherical source, all observers in one
    solution. Percents off with the sun low."""
    config = sk.Config()
    config.num_threads = threads
    config.single_scatter_source = sk.SingleScatterSource.Exact
    config.multiple_scatter_source = sk.MultipleScatterSource.DiscreteOrdinates
    config.num_streams = streams
    terms = air.legendre_terms(streams)
    config.num_singlescatter_moments = terms
    config.num_sza = 1 if sun_deg > 85 else 3
    level = steps((0, 3, 0.25), (3, 12, 0.5), (12, 100, 1.0))
    coarse = air.at(merged(level, np.asarray(observers_km, float), top=air.level_km[-1]))
    geometry = shells(sun_deg, coarse.level_km)
    view = rays(sun_deg, observers_km, np.asarray(directions, float))
    return run(config, geometry, view, coarse, terms, albedo)
