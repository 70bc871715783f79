//! An atmosphere over ground of any albedo, from one solution: black ground and lit ground apart.
//!
//! Light that never met the ground does not depend on it. The rest is found once, over ground of a
//! reference albedo. For another albedo A of the surroundings it is multiplied by the share
//! f(A) = A (1 − A₀ S) / (A₀ (1 − A S)): what the ground throws up falls back with the spherical
//! albedo S of the air seen from below, at each wavelength. Exact at A = 0 and A = A₀, and wherever
//! the ground is lit evenly; near the terminator it is an interpolation in A, see
//! `tests/physics/transport_everywhere.rs` for how good a one.

use super::air::Air;
use super::diffuse::{FieldLight, Series};
use super::field::Source;
use super::lanes::Lanes;
use super::settings::{TransportError, TransportSettings, check_albedo};
use super::view::{Eye, Seen, Sight};
use crate::optics::OpticalProfile;
use sky_core::quantity::{Angle, Length};

/// Albedo of the ground that the lit part is solved over: between grass and snow.
const REFERENCE_ALBEDO: f64 = 0.5;

/// A solved atmosphere over ground of any albedo.
#[derive(Clone, Debug)]
pub struct AnyGround {
    air: Air,
    /// Light that never met the ground.
    black: Source,
    /// Light that met the ground, of the reference albedo.
    lit: Source,
    /// By wavelength, seen from below.
    spherical_albedo: Vec<f64>,
}

/// The light along lines of sight, its parts apart: spectral radiance over solar irradiance \[sr⁻¹\],
/// entry `sight * wavelengths + wavelength`.
#[derive(Clone, Debug, PartialEq)]
pub struct LightParts {
    /// Sunlight that the air scattered once, over black ground.
    pub once: Vec<f64>,
    /// Light that the air scattered more often, over black ground.
    pub more: Vec<f64>,
    /// Transmittance of the path.
    pub transmittance: Vec<f64>,
    /// Light of the ground, of the reference albedo, that the air scatters into the path.
    lit_air: Vec<f64>,
    /// Irradiance over π of the ground where the path ends: over black ground, and what the light of
    /// ground of the reference albedo adds. 0 where it ends elsewhere.
    ground_black: Vec<f64>,
    ground_lit: Vec<f64>,
    spherical_albedo: Vec<f64>,
}

impl AnyGround {
    /// Solves for the diffuse light over black ground and of lit ground. The ground lies at the
    /// profile's lowest level.
    ///
    /// # Errors
    /// Refuses malformed tables; reports a series that does not converge.
    pub fn solve(
        optics: &OpticalProfile,
        settings: &TransportSettings,
    ) -> Result<Self, TransportError> {
        let air = Air::new(optics, settings)?;
        let rings = air.diffuse.rings(settings);
        let Series { total: black, .. } = air.diffuse.of_sun(&rings, 0.0, settings)?;
        let reflectance = REFERENCE_ALBEDO * core::f64::consts::FRAC_1_PI;
        let Series { total: lit, .. } =
            air.diffuse
                .of_ground(&rings, &black, reflectance, settings)?;
        let mut solved = Self {
            air,
            black: Source::new(black),
            lit: Source::new(lit),
            spherical_albedo: Vec::new(),
        };
        // under a sun overhead the ground is lit evenly as far as its light matters
        let (black, lit) = solved.ground_irradiance(1.0);
        solved.spherical_albedo = black
            .iter()
            .zip(&lit)
            .map(|(black, lit)| lit / (REFERENCE_ALBEDO * (black + lit)))
            .collect();
        Ok(solved)
    }

    /// Spherical albedo of the air seen from below, by wavelength.
    #[must_use]
    pub fn spherical_albedo(&self) -> &[f64] {
        &self.spherical_albedo
    }

    /// The light along lines of sight, for any albedo.
    ///
    /// An observer above the air sees what enters it from there. A line that would pass under the
    /// ground ends on it.
    ///
    /// # Errors
    /// Refuses an observer below the ground.
    pub fn light(
        &self,
        observer_altitude: Length,
        sun_zenith: Angle,
        sights: &[Sight],
    ) -> Result<LightParts, TransportError> {
        self.air.check_altitude(observer_altitude)?;
        let [black, lit] = [&self.black, &self.lit].map(|source| FieldLight {
            source,
            reflectance: 0.0,
        });
        let eye = Eye {
            altitude: observer_altitude,
            sun_zenith,
        };
        let seen = self.air.look(eye, sights, 0.0, &[black, lit]);
        let n = self.air.wavelengths();
        let (mut ground_black, mut ground_lit) = (Vec::new(), Vec::new());
        for sun in &seen.ground_sun {
            let (black, lit) = sun.map_or_else(
                || (vec![0.0; n], vec![0.0; n]),
                |cosine| self.ground_irradiance(cosine),
            );
            ground_black.extend(black.iter().map(|e| e * core::f64::consts::FRAC_1_PI));
            ground_lit.extend(lit.iter().map(|e| e * core::f64::consts::FRAC_1_PI));
        }
        let Seen {
            once,
            diffuse,
            transmittance,
            ..
        } = seen;
        let mut fields = diffuse.into_iter();
        Ok(LightParts {
            once,
            more: fields.next().unwrap_or_default(),
            lit_air: fields.next().unwrap_or_default(),
            transmittance,
            ground_black,
            ground_lit,
            spherical_albedo: self.spherical_albedo.clone(),
        })
    }

    /// Irradiance of the level ground over that of the sun: over black ground, and what the light of
    /// ground of the reference albedo adds.
    fn ground_irradiance(&self, sun_cosine: f64) -> (Vec<f64>, Vec<f64>) {
        let n = self.air.wavelengths();
        let spread = |light: &[Lanes], mut spectrum: Vec<f64>| {
            self.air.spread.add(light, &mut spectrum);
            spectrum
        };
        let at = |source: &Source| source.ground_irradiance(&self.air.diffuse.grid, sun_cosine);
        let beam = self.air.direct.beam(sun_cosine);
        let beam = beam
            .iter()
            .flatten()
            .take(n)
            .map(|x| f64::from(*x))
            .collect();
        (
            spread(&at(&self.black), beam),
            spread(&at(&self.lit), vec![0.0; n]),
        )
    }
}

impl LightParts {
    /// Number of wavelengths.
    #[must_use]
    pub fn wavelengths(&self) -> usize {
        self.spherical_albedo.len()
    }

    /// All light along each line, ground included, where the surroundings have one albedo and the
    /// ground that is seen has another.
    ///
    /// # Errors
    /// Refuses albedos outside 0..1.
    pub fn total(
        &self,
        surroundings_albedo: f64,
        seen_albedo: f64,
    ) -> Result<Vec<f64>, TransportError> {
        check_albedo(seen_albedo)?;
        let shares = self.shares(surroundings_albedo)?;
        let ground = self.white_ground(surroundings_albedo)?;
        Ok((0..self.once.len())
            .map(|i| {
                self.once[i]
                    + self.more[i]
                    + shares[i % shares.len()] * self.lit_air[i]
                    + seen_albedo * self.transmittance[i] * ground[i]
            })
            .collect())
    }

    /// Radiance of white ground where each line ends on it, as it is there, without the air before it;
    /// ground of another albedo has that share. 0 where a line ends elsewhere.
    ///
    /// # Errors
    /// Refuses albedos outside 0..1.
    pub fn white_ground(&self, surroundings_albedo: f64) -> Result<Vec<f64>, TransportError> {
        let shares = self.shares(surroundings_albedo)?;
        let ground = self.ground_black.iter().zip(&self.ground_lit).enumerate();
        Ok(ground
            .map(|(i, (black, lit))| black + shares[i % shares.len()] * lit)
            .collect())
    }

    /// By wavelength, what lit ground of the surroundings sends over what it sends at the reference
    /// albedo.
    fn shares(&self, surroundings_albedo: f64) -> Result<Vec<f64>, TransportError> {
        check_albedo(surroundings_albedo)?;
        let share = |s: &f64| {
            surroundings_albedo * (1.0 - REFERENCE_ALBEDO * s)
                / (REFERENCE_ALBEDO * (1.0 - surroundings_albedo * s))
        };
        Ok(self.spherical_albedo.iter().map(share).collect())
    }

    /// Light that the air of each path adds, where the surroundings have an albedo: the total without
    /// the ground at its end.
    ///
    /// # Errors
    /// Refuses albedos outside 0..1.
    pub fn inscatter(&self, surroundings_albedo: f64) -> Result<Vec<f64>, TransportError> {
        self.total(surroundings_albedo, 0.0)
    }
}
