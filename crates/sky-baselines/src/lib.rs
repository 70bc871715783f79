//! Published skies behind one interface, so that speed and accuracy can be compared.
//!
//! Purpose: each model as its paper has it, one paper a file, on the CPU
//! ([`sky_science::sky_model::SkyModel`]) and as WGSL ([`sky_science::shader_sky::ShaderSky`],
//! `shaders/baselines/NAME.wgsl`, the twin of the Rust text). What a paper leaves open, what its print
//! has wrong, and what was decided here stands at the top of its file. All models are listed once, in
//! [`MODELS`]. The CPU versions compute in `f32` for a direction, like the shaders; what depends on
//! observer, haze and sun is computed once for a frame.
//!
//! Turbidity is the project's (the report's Eq. 2.8). Models that take air from outside are driven by
//! [`atmosphere::Atmosphere`], the transport engine's air at three wavelengths; models with an
//! atmosphere of their own are matched at equal aerosol optical depth at 500 nm. A direction below
//! the horizon that a model knows comes out black; conditions outside its domain are an error.
//!
//! Out of scope: the sun's disc, the ground, clouds. Left out:
//! - the second order of T. Nishita et al. 1996: for each of its sample directions (eight in the paper)
//!   it integrates, at every point of the view ray, single scattering along a whole ray, and stores
//!   that in a volume of voxels for one sun and one haze. As a per-pixel shader that is eight times the
//!   cost of `nishita` for each of its 48 to 68 points, and as a table it is what [`bruneton`] does
//!   with all orders and `hillaire` with a closed series. Its place on a chart lies between theirs and
//!   single scattering's.
//! - O'Neil 2005, whose closed form holds for one shell and one scale depth (25 % of 2.5 % of the
//!   Earth's radius), not for ours.

pub mod aerial;
pub mod atmosphere;
pub mod bruneton;
mod cache;
pub mod cie;
pub mod dobashi;
pub mod hillaire;
pub mod hoffman;
pub mod hosek;
pub mod nielsen;
pub mod nishita;
pub mod nishita_table;
pub mod preetham;
mod ray;
#[cfg(test)]
mod shader_check;
pub mod texture;
mod view;

use sky_core::conditions::Domain;
use sky_science::shader_sky::ShaderSky;
use sky_science::sky_model::SkyModel;

/// A model of this crate: what a list, a chart and a test need to know of it.
#[derive(Clone, Copy, Debug)]
pub struct Baseline {
    /// The name by which it is asked for; that of the model and of its shader's file.
    pub name: &'static str,
    /// Where it was published.
    pub citation: &'static str,
    /// Where it claims to be valid, in the project's turbidity.
    pub domain: Domain,
    /// Whether it gives luminance alone; its chromaticity is then D65 everywhere.
    pub luminance_only: bool,
    /// Whether its air is its own, matched to ours at equal aerosol optical depth.
    pub own_atmosphere: bool,
    /// Makes the model.
    pub sky: fn() -> Box<dyn SkyModel + Send>,
    /// Makes the model with its shader, where it has one.
    pub shader_sky: Option<fn() -> Box<dyn ShaderSky + Send>>,
}

impl Baseline {
    /// Bytes of the model's tables.
    #[must_use]
    pub fn table_bytes(&self) -> usize {
        // the one without a shader
        self.shader_sky.map_or_else(
            || bruneton::Bruneton::default().table_bytes(),
            |make| make().table_bytes(),
        )
    }
}

/// Makes the two constructors of a model's row.
macro_rules! makers {
    ($model:ty) => {
        (
            || Box::<$model>::default(),
            Some(|| Box::<$model>::default()),
        )
    };
}

type Makers = (
    fn() -> Box<dyn SkyModel + Send>,
    Option<fn() -> Box<dyn ShaderSky + Send>>,
);

const fn row(
    name: &'static str,
    citation: &'static str,
    domain: Domain,
    [luminance_only, own_atmosphere]: [bool; 2],
    (sky, shader_sky): Makers,
) -> Baseline {
    Baseline {
        name,
        citation,
        domain,
        luminance_only,
        own_atmosphere,
        sky,
        shader_sky,
    }
}

/// Every model. The two flags: luminance alone; an atmosphere of its own.
pub const MODELS: [Baseline; 11] = [
    row(
        "cie-overcast",
        "Moon & Spencer 1942, Illumination from a non-uniform sky; CIE 1955",
        cie::OVERCAST_DOMAIN,
        [true, true],
        makers!(cie::CieOvercast),
    ),
    row(
        "cie-clear",
        "Kittler 1967, Standardisation of outdoor conditions for the calculation of daylight factor with clear skies; CIE 1973",
        cie::CLEAR_DOMAIN,
        [true, true],
        makers!(cie::CieClear),
    ),
    row(
        "preetham",
        "Preetham, Shirley & Smits 1999, A practical analytic model for daylight",
        preetham::DOMAIN,
        [false, true],
        makers!(preetham::Preetham),
    ),
    row(
        "hosek",
        "Hosek & Wilkie 2012, An analytic model for full spectral sky-dome radiance",
        hosek::DOMAIN,
        [false, true],
        makers!(hosek::Hosek),
    ),
    row(
        "hoffman",
        "Hoffman & Preetham 2002, Rendering outdoor light scattering in real time",
        hoffman::DOMAIN,
        [false, true],
        makers!(hoffman::Hoffman),
    ),
    row(
        "nielsen",
        "Nielsen 2003, Real time rendering of atmospheric scattering effects for flight simulators (second-hand)",
        nielsen::DOMAIN,
        [false, true],
        makers!(nielsen::Nielsen),
    ),
    row(
        "nishita",
        "Nishita, Sirai, Tadamura & Nakamae 1993, Display of the Earth taking into account atmospheric scattering (marched)",
        nishita::DOMAIN,
        [false, true],
        makers!(nishita::Nishita),
    ),
    row(
        "nishita-table",
        "Nishita, Sirai, Tadamura & Nakamae 1993 (with the table over shells and cylinders)",
        nishita::DOMAIN,
        [false, true],
        makers!(nishita_table::NishitaTable),
    ),
    row(
        "dobashi",
        "Dobashi, Yamamoto & Nishita 2002, Interactive rendering of atmospheric scattering effects using graphics hardware",
        dobashi::DOMAIN,
        [false, true],
        makers!(dobashi::Dobashi),
    ),
    row(
        "hillaire",
        "Hillaire 2020, A scalable and production ready sky and atmosphere rendering technique",
        hillaire::DOMAIN,
        [false, false],
        makers!(hillaire::Hillaire),
    ),
    row(
        "bruneton",
        "Bruneton & Neyret 2008, Precomputed atmospheric scattering",
        bruneton::DOMAIN,
        [false, false],
        (|| Box::<bruneton::Bruneton>::default(), None),
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader_check::conditions;
    use sky_core::direction::SkyDirection;

    #[test]
    fn the_list_says_what_the_models_say() {
        for model in &MODELS {
            let sky = (model.sky)();
            assert_eq!(sky.name(), model.name);
            assert_eq!(*sky.domain(), model.domain);
            if let Some(make) = model.shader_sky {
                assert_eq!(make().name(), model.name);
                assert!(make().shader().contains("fn baseline_xyz("));
            }
        }
        let mut names = MODELS.map(|m| m.name);
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]));
    }

    #[test]
    fn every_model_is_finite_and_refuses_what_it_does_not_know() {
        let mut directions = Vec::new();
        for zenith in [0.0, 30.0, 60.0, 80.0, 89.0, 90.0, 92.0, 130.0, 180.0] {
            for azimuth in [0.0, 45.0, 180.0] {
                directions.push(SkyDirection::from_degrees(zenith, azimuth));
            }
        }
        for model in &MODELS {
            let sky = (model.sky)();
            let d = model.domain;
            for altitude in d.altitude_km {
                for turbidity in d.turbidity {
                    for sun in d.sun_zenith_deg {
                        let c = conditions(altitude, turbidity, sun);
                        let map = sky.yxy_map(&c, &directions).unwrap();
                        for (light, direction) in map.iter().zip(&directions) {
                            let sane = light.luminance_cd_m2.is_finite()
                                && light.x.is_finite()
                                && light.y.is_finite();
                            assert!(sane, "{} {c:?} {direction:?} {light:?}", model.name);
                        }
                        assert_eq!(map.last().map(|l| l.luminance_cd_m2), Some(0.0));
                    }
                }
            }
            for c in [
                conditions(d.altitude_km[1] + 1.0, 3.0, 45.0),
                conditions(0.0, d.turbidity[1] + 1.0, 45.0),
                conditions(0.0, f64::NAN, 45.0),
                conditions(0.0, 3.0, d.sun_zenith_deg[1] + 1.0),
            ] {
                assert!(
                    sky.yxy_map(&c, &directions).is_err(),
                    "{} {c:?}",
                    model.name
                );
                if let Some(make) = model.shader_sky {
                    assert!(make().shader_frame(&c).is_err());
                }
            }
        }
    }
}
