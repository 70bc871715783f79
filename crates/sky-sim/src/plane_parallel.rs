//! Single scattering in flat layers: what the sky would be without the Earth's curvature.
//!
//! For comparison with the transport engine's first order, in closed form for each layer. Out of scope:
//! other orders, and the horizontal, where flat air has no end.

use sky_core::direction::SkyDirection;
use sky_core::quantity::{Angle, Length};

use crate::optics::OpticalProfile;
use sky_science::phase::{rayleigh, two_term};

/// Below this the exponent of a layer counts as even \[1\].
const EVEN: f64 = 1e-6;

/// Radiance per unit solar irradiance of light scattered once \[sr⁻¹\], entry
/// `direction * wavelengths + wavelength`. Black at and below the horizontal, and with the sun there.
///
/// With the depth τ counted from the observer upward, τ₀ that of all air above, μ and μ₀ the cosines of
/// view and sun: `L = ∫ ω₀ P(γ) exp(−(τ₀ − τ)/μ₀ − τ/μ) dτ/μ`.
#[must_use]
pub fn single_scattering_ratio(
    optics: &OpticalProfile,
    observer_altitude: Length,
    sun_zenith: Angle,
    directions: &[SkyDirection],
) -> Vec<f64> {
    let wavelengths = optics.wavelength_nm.len();
    let mut out = vec![0.0; directions.len() * wavelengths];
    let to_sun = sun_zenith.radians().cos();
    if to_sun <= 0.0 {
        return out;
    }
    let layers = layers_above(&optics.altitude_km, observer_altitude.km());
    for (direction, out) in directions.iter().zip(out.chunks_exact_mut(wavelengths)) {
        let up = direction.view_zenith.radians().cos();
        if up <= 0.0 {
            continue;
        }
        let mu = direction.cos_scattering_angle(sun_zenith);
        let molecules = rayleigh(mu, optics.rayleigh_depolarization);
        let difference = 1.0 / to_sun - 1.0 / up;
        for (w, radiance) in out.iter_mut().enumerate() {
            // mean coefficients of a layer: extinction, scattering times phase function
            let mean = |layer: &Layer| {
                let [below, above] = layer.levels.map(|level| {
                    let i = level * wavelengths + w;
                    let haze = optics.aerosol_scattering_per_km[i];
                    let air = optics.rayleigh_scattering_per_km[i];
                    let phase = two_term(
                        mu,
                        optics.aerosol_g[i],
                        optics.aerosol_g2[i],
                        optics.aerosol_g_weight[i],
                    );
                    let absorbed =
                        optics.gas_absorption_per_km[i] + optics.aerosol_absorption_per_km[i];
                    [air + haze + absorbed, air * molecules + haze * phase]
                });
                core::array::from_fn(|k| below[k] + layer.middle * (above[k] - below[k]))
            };
            let coefficients: Vec<[f64; 2]> = layers.iter().map(mean).collect();
            let whole: f64 = coefficients
                .iter()
                .zip(&layers)
                .map(|([extinction, _], layer)| extinction * layer.thickness_km)
                .sum();
            let mut depth = 0.0;
            for ([extinction, scattered], layer) in coefficients.iter().zip(&layers) {
                let through = extinction * layer.thickness_km;
                let begin = (difference * depth - whole / to_sun).exp();
                let exponent = difference * through;
                let mean = if exponent.abs() < EVEN {
                    1.0
                } else {
                    exponent.exp_m1() / exponent
                };
                *radiance += scattered * layer.thickness_km / up * begin * mean;
                depth += through;
            }
        }
    }
    out
}

/// A layer above the observer: the levels that it lies between, where its middle is between them, and
/// how thick it is.
struct Layer {
    levels: [usize; 2],
    middle: f64,
    thickness_km: f64,
}

fn layers_above(altitude_km: &[f64], observer_km: f64) -> Vec<Layer> {
    altitude_km
        .windows(2)
        .enumerate()
        .filter(|(_, ends)| ends[1] > observer_km)
        .map(|(i, ends)| {
            let bottom = ends[0].max(observer_km);
            let middle = 0.5 * (bottom + ends[1]);
            Layer {
                levels: [i, i + 1],
                middle: (middle - ends[0]) / (ends[1] - ends[0]),
                thickness_km: ends[1] - bottom,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::OpticsSettings;
    use crate::profile::AtmosphereProfile;
    use crate::transport::{Transport, TransportSettings};
    use sky_core::haze::Haze;

    fn optics() -> OpticalProfile {
        let settings = OpticsSettings {
            haze: Haze::Turbidity(2.0),
            wavelength_nm: vec![450.0, 650.0],
            ..OpticsSettings::with_step_nm(20).expect("a step")
        };
        OpticalProfile::build(&AtmosphereProfile::general(), &settings).expect("optics")
    }

    #[test]
    fn high_up_the_earth_is_flat() {
        let optics = optics();
        let settings = TransportSettings {
            degree: Some(1),
            tolerance: 0.5,
            ..TransportSettings::default()
        };
        let spherical = Transport::solve(&optics, 0.0, &settings).expect("a solution");
        let sun = Angle::from_degrees(40.0);
        let directions = [(0.0, 0.0), (30.0, 120.0), (60.0, 60.0), (70.0, 180.0)]
            .map(|(zenith, azimuth)| SkyDirection::from_degrees(zenith, azimuth));
        for km in [0.0, 4.0, 12.0] {
            let here = Length::from_km(km);
            let flat = single_scattering_ratio(&optics, here, sun, &directions);
            let round = spherical.single_scattering_ratio(here, sun, &directions);
            for (flat, round) in flat.iter().zip(&round) {
                assert!((flat / round - 1.0).abs() < 0.02, "{km} km: {flat} {round}");
            }
        }
        // near the horizon it is not: 1/cos is 28.7 there, the air mass 19.8
        let low = [SkyDirection::from_degrees(88.0, 90.0)];
        let here = Length::from_km(12.0);
        let flat = single_scattering_ratio(&optics, here, sun, &low)[1];
        let round = spherical.single_scattering_ratio(here, sun, &low)[1];
        assert!(flat > 1.15 * round, "{flat} {round}");
    }

    #[test]
    fn black_without_a_sun_or_a_sky() {
        let optics = optics();
        let here = Length::from_km(6.0);
        let below = [SkyDirection::from_degrees(91.0, 0.0)];
        let up = [SkyDirection::from_degrees(10.0, 0.0)];
        for (sun, directions) in [(30.0, &below), (90.5, &up)] {
            let sun = Angle::from_degrees(sun);
            let found = single_scattering_ratio(&optics, here, sun, directions);
            assert!(found.iter().all(|l| *l == 0.0), "{found:?}");
        }
    }
}
