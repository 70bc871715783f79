//! What an eye sees: light gathered along lines of sight through a solved atmosphere.

use super::air::Air;
use super::diffuse::{FieldLight, Scratch};
use super::lanes::{Lanes, ZERO};
use super::path::{Path, Ray, Steps, VIEW_SAMPLING};
use super::template::Template;
use rayon::prelude::*;
use sky_core::direction::SkyDirection;
use sky_core::quantity::{Angle, EARTH_RADIUS_KM, Length};

/// Most rays that are walked together.
const FAN: usize = 32;

/// A line of sight from the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Where it goes; azimuth relative to the sun.
    pub direction: SkyDirection,
    /// Where it ends; `None` on the ground or in space.
    pub length: Option<Length>,
}

impl Sight {
    /// A line that ends on the ground or in space.
    #[must_use]
    pub const fn whole(direction: SkyDirection) -> Self {
        Self {
            direction,
            length: None,
        }
    }

    fn reach_km(&self) -> f64 {
        self.length.map_or(f64::INFINITY, Length::km)
    }

    /// Whether two lines share a path but for its azimuth.
    fn shares_path(&self, other: &Self) -> bool {
        let key = |sight: &Self| {
            let zenith = sight.direction.view_zenith.radians();
            [zenith, sight.reach_km()].map(f64::to_bits)
        };
        key(self) == key(other)
    }
}

/// Where the eye is, and the sun above it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eye {
    pub(super) altitude: Length,
    pub(super) sun_zenith: Angle,
}

/// What is gathered along lines of sight; tables are `[sight * wavelengths + wavelength]`.
#[derive(Clone, Debug, Default)]
pub(super) struct Seen {
    /// Sunlight scattered once \[sr⁻¹\].
    pub(super) once: Vec<f64>,
    /// Light of each field \[sr⁻¹\].
    pub(super) diffuse: Vec<Vec<f64>>,
    /// Transmittance of the path.
    pub(super) transmittance: Vec<f64>,
    /// By sight: cosine of the local sun zenith angle at the ground where the path ends there.
    pub(super) ground_sun: Vec<Option<f64>>,
}

impl Seen {
    fn with_fields(fields: usize) -> Self {
        Self {
            diffuse: vec![Vec::new(); fields],
            ..Self::default()
        }
    }

    fn append(&mut self, mut other: Self) {
        self.once.append(&mut other.once);
        self.transmittance.append(&mut other.transmittance);
        self.ground_sun.append(&mut other.ground_sun);
        for (all, more) in self.diffuse.iter_mut().zip(&mut other.diffuse) {
            all.append(more);
        }
    }

    /// Lines that meet no air.
    fn push_space(&mut self, sights: usize, wavelengths: usize) {
        let all = sights * wavelengths;
        for dark in core::iter::once(&mut self.once).chain(&mut self.diffuse) {
            dark.resize(dark.len() + all, 0.0);
        }
        let clear = self.transmittance.len() + all;
        self.transmittance.resize(clear, 1.0);
        self.ground_sun.resize(self.ground_sun.len() + sights, None);
    }
}

impl Air {
    /// Looks along lines; the ground at their ends throws back the sun's beam by a reflectance
    /// \[sr⁻¹\], and each field's light by that field's.
    pub(super) fn look(
        &self,
        eye: Eye,
        sights: &[Sight],
        reflectance: f64,
        fields: &[FieldLight<'_>],
    ) -> Seen {
        let rings: Vec<&[Sight]> = sights
            .chunk_by(Sight::shares_path)
            .flat_map(|ring| ring.chunks(FAN))
            .collect();
        let seen: Vec<Seen> = rings
            .par_iter()
            .map_init(Scratch::default, |scratch, ring| {
                let mut seen = Seen::with_fields(fields.len());
                if let Some((rays, reach)) = self.rays(eye, ring) {
                    self.add_once(&rays, reach, reflectance, scratch, &mut seen);
                    self.add_fields(&rays, reach, fields, scratch, &mut seen);
                } else {
                    seen.push_space(ring.len(), self.wavelengths());
                }
                seen
            })
            .collect();
        let mut all = Seen::with_fields(fields.len());
        for seen in seen {
            all.append(seen);
        }
        all
    }

    /// The rays of a ring from where they meet the air, and how far they go from there \[km\];
    /// `None` if they miss it.
    fn rays(&self, eye: Eye, ring: &[Sight]) -> Option<(Vec<Ray>, f64)> {
        let medium = &self.direct.medium;
        let radius = EARTH_RADIUS_KM + eye.altitude.km().max(medium.ground_km());
        let cosine = ring[0].direction.view_zenith.radians().cos();
        let sun_cosine = eye.sun_zenith.radians().cos();
        let ray = |sight: &Sight| Ray {
            radius,
            cosine,
            sun_cosine,
            cos_gamma: sight.direction.cos_scattering_angle(eye.sun_zenith),
        };
        let before = Ray::upright(radius, cosine).before_sphere(medium.top_radius())?;
        let reach = ring[0].reach_km() - before;
        if reach <= 0.0 && before > 0.0 {
            return None;
        }
        let entering = |ray: Ray| {
            if before > 0.0 {
                Ray {
                    radius: medium.top_radius(),
                    ..ray.moved(before)
                }
            } else {
                ray
            }
        };
        Some((ring.iter().map(ray).map(entering).collect(), reach))
    }

    /// Adds sunlight scattered once, and what is known of the paths.
    fn add_once(
        &self,
        rays: &[Ray],
        reach: f64,
        reflectance: f64,
        scratch: &mut Scratch,
        seen: &mut Seen,
    ) {
        let (n, medium) = (self.wavelengths(), &self.direct.medium);
        let mut radiance = vec![ZERO; medium.vectors];
        // what the Earth's shadow does not cut is the same for the whole ring
        let mut uncut = None;
        for ray in rays {
            let cut = ray
                .shadow_edges(medium.ground_radius(), reach)
                .next()
                .is_some();
            let cut_path;
            let template = if cut {
                cut_path = self.once_template(ray, reach, &mut scratch.path);
                &cut_path
            } else {
                uncut.get_or_insert_with(|| self.once_template(ray, reach, &mut scratch.path))
            };
            radiance.fill(ZERO);
            self.direct
                .add_sunlight(ray, template, reflectance, &mut scratch.sun, &mut radiance);
            let spectrum = |lanes: &[Lanes]| {
                let lanes: Vec<f64> = lanes
                    .iter()
                    .flatten()
                    .take(n)
                    .map(|x| f64::from(*x))
                    .collect();
                lanes
            };
            seen.once.extend(spectrum(&radiance));
            seen.transmittance.extend(spectrum(&template.through));
            seen.ground_sun.push(template.ground_sun_cosine(ray));
        }
    }

    /// Adds the light of fields.
    fn add_fields(
        &self,
        rays: &[Ray],
        reach: f64,
        fields: &[FieldLight<'_>],
        scratch: &mut Scratch,
        seen: &mut Seen,
    ) {
        if fields.is_empty() {
            return;
        }
        let (n, vectors) = (self.wavelengths(), self.diffuse.air.medium.vectors);
        let template = self
            .diffuse
            .observer_template(&rays[0], reach, &mut scratch.path);
        let mut radiance = vec![ZERO; rays.len() * vectors];
        for (light, out) in fields.iter().zip(&mut seen.diffuse) {
            radiance.fill(ZERO);
            self.diffuse
                .add_diffuse(rays, &template, *light, &mut scratch.fan, &mut radiance);
            let start = out.len();
            out.resize(start + rays.len() * n, 0.0);
            for (light, out) in radiance
                .chunks_exact(vectors)
                .zip(out[start..].chunks_exact_mut(n))
            {
                self.spread.add(light, out);
            }
        }
    }

    /// The path of a ray for sunlight scattered once.
    fn once_template(&self, ray: &Ray, reach: f64, path: &mut Path) -> Template {
        let medium = &self.direct.medium;
        let steps = Steps {
            shells: &self.view_shells,
            sampling: &VIEW_SAMPLING,
        };
        path.trace(ray, reach, medium, steps);
        pulp::Arch::new().dispatch(|| Template::of_path(ray, path, medium))
    }
}
