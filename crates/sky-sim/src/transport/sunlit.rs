//! Sunlight that is scattered once, by air or ground.

use super::lanes::{Lanes, ZERO, add_product, add_scaled, lane};
use super::medium::Medium;
use super::path::Ray;
use super::sun::{SunPlace, SunTable};
use super::template::Template;
use crate::optics::OpticalProfile;
use sky_science::phase;

/// Air and ground in sunlight.
#[derive(Clone, Debug)]
pub(super) struct Sunlit {
    pub(super) medium: Medium,
    pub(super) sun: SunTable,
}

impl Sunlit {
    pub(super) fn new(optics: &OpticalProfile) -> Self {
        let medium = Medium::new(optics);
        Self {
            sun: SunTable::new(&medium),
            medium,
        }
    }

    /// The sun's irradiance on the level ground, over that of space, from the local sun's cosine.
    pub(super) fn beam(&self, sun_cosine: f64) -> Vec<Lanes> {
        let mut beam = vec![ZERO; self.medium.vectors];
        let place = self.sun.place(self.medium.ground_km(), sun_cosine);
        for (v, beam) in beam.iter_mut().enumerate() {
            let transmittance = self.sun.transmittance(&place, v);
            add_scaled(beam, lane(sun_cosine.max(0.0)), &transmittance);
        }
        beam
    }

    /// Adds sunlight scattered once along a ray to `radiance`; `reflectance` is the ground's albedo
    /// over π \[sr⁻¹\].
    pub(super) fn add_sunlight(
        &self,
        ray: &Ray,
        template: &Template,
        reflectance: f64,
        sun: &mut Vec<SunPlace>,
        radiance: &mut [Lanes],
    ) {
        sun.clear();
        sun.extend(
            template
                .stops
                .iter()
                .map(|stop| self.sun.place(stop.z, stop.sun_cosine(ray))),
        );
        if sun.iter().any(|s| s.lit) {
            pulp::Arch::new().dispatch(SunlitStops {
                medium: &self.medium,
                table: &self.sun,
                ray,
                template,
                sun,
                reflectance,
                radiance,
            });
        }
    }
}

/// Inner loop: sunlight scattered once at the stops of a ray, all wavelengths.
struct SunlitStops<'a> {
    medium: &'a Medium,
    table: &'a SunTable,
    ray: &'a Ray,
    template: &'a Template,
    sun: &'a [SunPlace],
    reflectance: f64,
    radiance: &'a mut [Lanes],
}

impl pulp::NullaryFnOnce for SunlitStops<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            medium: m,
            table,
            ray,
            template,
            sun,
            reflectance,
            radiance,
        } = self;
        let rayleigh_phase = lane(phase::rayleigh(ray.cos_gamma, m.depolarization));
        let vectors = radiance.len();
        for (k, stop) in template.stops.iter().enumerate() {
            if !sun[k].lit {
                continue;
            }
            let hazy = m.hazy[stop.place.level] || m.hazy[stop.place.level + 1];
            for (v, out) in radiance.iter_mut().enumerate() {
                let mut scattered = ZERO;
                let at = k * vectors + v;
                add_scaled(&mut scattered, rayleigh_phase, &template.rayleigh[at]);
                if hazy {
                    let phase = m.aerosol_phase(stop.place, v, ray.cos_gamma);
                    add_product(&mut scattered, &template.aerosol[at], &phase);
                }
                add_product(out, &table.transmittance(&sun[k], v), &scattered);
            }
        }
        let last = template.stops.len() - 1;
        let cosine = template.ground_sun_cosine(ray).unwrap_or(0.0);
        if cosine > 0.0 && sun[last].lit {
            for (v, through) in template.through.iter().enumerate() {
                let mut reflected = ZERO;
                add_scaled(&mut reflected, lane(cosine * reflectance), through);
                add_product(
                    &mut radiance[v],
                    &table.transmittance(&sun[last], v),
                    &reflected,
                );
            }
        }
    }
}
