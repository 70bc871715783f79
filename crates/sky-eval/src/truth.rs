//! The engines as skies: what the tables are fitted to and judged by.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::Result;
use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::SkyDirection;
use sky_core::extinction::Extinction;
use sky_core::haze::Haze;
use sky_core::quantity::Length;
use sky_science::cie::ColorWeights;
use sky_science::sky_model::{SkyError, SkyModel};
use sky_science::spectrum::Spectrum;
use sky_sim::optics::{OpticalProfile, OpticsSettings};
use sky_sim::profile::AtmosphereProfile;
use sky_sim::smarts::SmartsSky;
use sky_sim::solar::SolarSpectrum;
use sky_sim::transport::{AnyGround, LightParts, Sight, Transport, TransportSettings};

use crate::extinction;

/// Albedo of the ground where none is given.
pub const DEFAULT_GROUND_ALBEDO: f64 = 0.2;

/// Solved atmospheres that are kept.
const KEPT: usize = 12;

/// What the transport engine answers for: the ground lies at 0 km, or at the observer's feet if they are
/// lower.
pub const TRANSPORT_DOMAIN: Domain = Domain {
    altitude_km: [-0.5, 100.0],
    turbidity: [1.0, 12.0],
    sun_zenith_deg: [0.0, 108.0],
    below_horizontal: true,
};

/// What both engines answer for, and tables may be made for.
pub const DOMAIN: Domain = Domain {
    altitude_km: [0.0, 30.0],
    turbidity: [1.0, 12.0],
    sun_zenith_deg: [0.0, 96.0],
    below_horizontal: true,
};

/// An atmosphere, its ground and its colors, shared by both engines.
#[derive(Clone, Debug)]
struct Air {
    profile: AtmosphereProfile,
    settings: OpticsSettings,
    ground_albedo: f64,
    weights: ColorWeights,
}

impl Air {
    fn new(
        profile: AtmosphereProfile,
        settings: OpticsSettings,
        ground_albedo: f64,
    ) -> Result<Self> {
        let sun = SolarSpectrum::g173();
        let sun = Spectrum::new(sun.wavelength_nm, sun.irradiance_w_m2_nm)?;
        let weights = ColorWeights::for_radiance_ratio(&settings.wavelength_nm, &sun)?;
        // whatever can be wrong with the settings shows here, not in the middle of a map
        OpticalProfile::build(&profile, &settings)?;
        Ok(Self {
            profile,
            settings,
            ground_albedo,
            weights,
        })
    }

    fn with_turbidity(&self, turbidity: f64) -> OpticsSettings {
        OpticsSettings {
            haze: Haze::Turbidity(turbidity),
            ..self.settings.clone()
        }
    }

    fn colors(&self, ratios: &[f64]) -> Vec<Yxy> {
        ratios
            .chunks_exact(self.settings.wavelength_nm.len())
            .map(|s| self.weights.yxy(s))
            .collect()
    }
}

/// Names of the engines.
const TRANSPORT: &str = "transport";
const SMARTS: &str = "smarts";

/// What an engine says that has no answer within the domain.
fn gave_up(sky: &'static str, turbidity: f64, why: &dyn fmt::Display) -> SkyError {
    SkyError::GaveUp {
        sky,
        turbidity,
        why: why.to_string(),
    }
}

/// Engines by the bits of the turbidity and of the ground's altitude, the oldest first to go.
struct Cache<T>(Mutex<Kept<T>>);

/// What is kept, and its keys from the oldest to the newest.
type Kept<T> = (BTreeMap<[u64; 2], Arc<T>>, Vec<[u64; 2]>);

impl<T> fmt::Debug for Cache<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Cache")
    }
}

impl<T> Cache<T> {
    fn new() -> Self {
        Self(Mutex::new((BTreeMap::new(), Vec::new())))
    }

    /// The engine of a turbidity and a ground. It is made without holding the lock: its own work runs on
    /// the threads that may be waiting here.
    fn get<E>(
        &self,
        turbidity: f64,
        ground: Length,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<Arc<T>, E> {
        let key = [turbidity, ground.km()].map(f64::to_bits);
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(engine) = lock().0.get(&key) {
            return Ok(Arc::clone(engine));
        }
        let made = Arc::new(make()?);
        let mut guard = lock();
        let (engines, order) = &mut *guard;
        if !engines.contains_key(&key) {
            order.push(key);
            if order.len() > KEPT {
                engines.remove(&order.remove(0));
            }
        }
        Ok(Arc::clone(engines.entry(key).or_insert(made)))
    }
}

/// The transport engine as a sky: the truth.
#[derive(Debug)]
pub struct TransportSky {
    air: Air,
    transport: TransportSettings,
    solved: Cache<Transport>,
    any_ground: Cache<AnyGround>,
}

impl TransportSky {
    /// A sky over a ground of given albedo; the haze of `settings` is replaced by each call's.
    ///
    /// # Errors
    /// When the settings do not suit the profile.
    pub fn new(
        profile: AtmosphereProfile,
        settings: OpticsSettings,
        ground_albedo: f64,
    ) -> Result<Self> {
        let air = Air::new(profile, settings, ground_albedo)?;
        let transport = TransportSettings::default();
        Transport::check(ground_albedo)?;
        Ok(Self {
            air,
            transport,
            solved: Cache::new(),
            any_ground: Cache::new(),
        })
    }

    /// The profile.
    #[must_use]
    pub const fn profile(&self) -> &AtmosphereProfile {
        &self.air.profile
    }

    /// The settings of the optics; their haze is not used.
    #[must_use]
    pub const fn settings(&self) -> &OpticsSettings {
        &self.air.settings
    }

    /// The extinction of its air, as a table carries it.
    ///
    /// # Errors
    /// When it cannot be reduced.
    pub fn extinction(&self) -> Result<Extinction> {
        extinction::reduce(&self.air.profile, &self.air.settings)
    }

    /// Albedo of the ground.
    #[must_use]
    pub const fn ground_albedo(&self) -> f64 {
        self.air.ground_albedo
    }

    /// The same sky solved with other settings of the engine.
    #[must_use]
    pub fn with_transport_settings(mut self, transport: TransportSettings) -> Self {
        self.transport = transport;
        self.solved = Cache::new();
        self.any_ground = Cache::new();
        self
    }

    /// Radiance per unit of solar irradiance \[sr⁻¹\], entry `direction * wavelengths + wavelength`.
    ///
    /// # Errors
    /// When the conditions lie outside the domain, or the engine gives up on the air.
    pub fn radiance_ratio(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<f64>, SkyError> {
        TRANSPORT_DOMAIN.check(conditions)?;
        let solved = self.solved_over(conditions.turbidity, ground(conditions))?;
        Ok(solved.radiance_ratio(
            conditions.observer_altitude,
            conditions.sun_zenith,
            directions,
        ))
    }

    /// The optics of a turbidity.
    ///
    /// # Errors
    /// When there are no optics of that turbidity.
    pub fn optics(&self, turbidity: f64) -> Result<OpticalProfile, SkyError> {
        OpticalProfile::build(&self.air.profile, &self.air.with_turbidity(turbidity))
            .map_err(|why| gave_up(TRANSPORT, turbidity, &why))
    }

    /// Lights from radiance per unit of solar irradiance, as [`Self::radiance_ratio`] has it.
    #[must_use]
    pub fn colors(&self, ratios: &[f64]) -> Vec<Yxy> {
        self.air.colors(ratios)
    }

    /// The light along lines of sight, its parts apart, for ground of any albedo: spectral radiance per
    /// unit of solar irradiance \[sr⁻¹\]. This sky's own albedo has no part in it.
    ///
    /// # Errors
    /// When the conditions lie outside the domain, or the engine gives up on the air.
    pub fn parts(&self, conditions: &Conditions, sights: &[Sight]) -> Result<LightParts, SkyError> {
        TRANSPORT_DOMAIN.check(conditions)?;
        let (turbidity, ground) = (conditions.turbidity, ground(conditions));
        let give_up = |why| gave_up(TRANSPORT, turbidity, &why);
        let solved = self.any_ground.get(turbidity, ground, || {
            let optics = self.optics_over(turbidity, ground)?;
            AnyGround::solve(&optics, &self.transport).map_err(give_up)
        })?;
        solved
            .light(conditions.observer_altitude, conditions.sun_zenith, sights)
            .map_err(give_up)
    }

    /// The solved atmosphere of a turbidity, the ground at 0 km.
    ///
    /// # Errors
    /// When the air is too dense for the engine.
    pub fn solved(&self, turbidity: f64) -> Result<Arc<Transport>, SkyError> {
        self.solved_over(turbidity, Length::ZERO)
    }

    fn solved_over(&self, turbidity: f64, ground: Length) -> Result<Arc<Transport>, SkyError> {
        self.solved.get(turbidity, ground, || {
            Transport::solve(
                &self.optics_over(turbidity, ground)?,
                self.air.ground_albedo,
                &self.transport,
            )
            .map_err(|why| gave_up(TRANSPORT, turbidity, &why))
        })
    }

    fn optics_over(&self, turbidity: f64, ground: Length) -> Result<OpticalProfile, SkyError> {
        self.optics(turbidity)?
            .down_to(ground)
            .map_err(|why| gave_up(TRANSPORT, turbidity, &why))
    }
}

/// The ground below an observer.
fn ground(conditions: &Conditions) -> Length {
    Length::from_km(conditions.observer_altitude.km().min(0.0))
}

impl SkyModel for TransportSky {
    fn name(&self) -> &'static str {
        TRANSPORT
    }

    fn domain(&self) -> &Domain {
        &TRANSPORT_DOMAIN
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        let ratios = self.radiance_ratio(conditions, directions)?;
        Ok(self.air.colors(&ratios))
    }
}

/// The parametric engine as a sky.
#[derive(Debug)]
pub struct SmartsSkyModel {
    air: Air,
    made: Cache<SmartsSky>,
    unit_sun: SolarSpectrum,
}

impl SmartsSkyModel {
    /// A sky over a ground of given albedo; the haze of `settings` is replaced by each call's.
    ///
    /// # Errors
    /// When the settings do not suit the profile.
    pub fn new(
        profile: AtmosphereProfile,
        settings: OpticsSettings,
        ground_albedo: f64,
    ) -> Result<Self> {
        let unit_sun = SolarSpectrum {
            irradiance_w_m2_nm: vec![1.0; settings.wavelength_nm.len()],
            wavelength_nm: settings.wavelength_nm.clone(),
        };
        SmartsSky::new(&profile, &settings, ground_albedo)?.with_sun(&unit_sun)?;
        Ok(Self {
            air: Air::new(profile, settings, ground_albedo)?,
            made: Cache::new(),
            unit_sun,
        })
    }
}

impl SkyModel for SmartsSkyModel {
    fn name(&self) -> &'static str {
        SMARTS
    }

    fn domain(&self) -> &Domain {
        &DOMAIN
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        DOMAIN.check(conditions)?;
        let sky = self.made.get(conditions.turbidity, Length::ZERO, || {
            let settings = self.air.with_turbidity(conditions.turbidity);
            SmartsSky::new(&self.air.profile, &settings, self.air.ground_albedo)
                .and_then(|sky| sky.with_sun(&self.unit_sun))
                .map_err(|why| gave_up(SMARTS, conditions.turbidity, &why))
        })?;
        let map = sky
            .radiance(
                conditions.observer_altitude,
                conditions.sun_zenith,
                directions,
            )
            .map_err(|why| gave_up(SMARTS, conditions.turbidity, &why))?;
        Ok(self.air.colors(&map.spectral_radiance))
    }
}
