//! From a sky to the values of a table: every node of a grid, fitted.
//!
//! Works on anything that is a [`SkyModel`]. Perez forms are fitted node by node with
//! Levenberg–Marquardt; the extended form, linear in its coefficients, is fitted for all altitudes and
//! suns of a turbidity at once, to skies at the nodes *and between them*, so that what is smallest
//! is the error of the interpolated table. Out of scope: the file (`sky_core::lut`).

use rayon::prelude::*;
use sky_core::air_mass::relative_air_mass;
use sky_core::axis::{Axis, AxisError};
use sky_core::color::Yxy;
use sky_core::conditions::Conditions;
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::extended;
use sky_core::lut::Form;
use sky_core::quantity::{Angle, Length, single};
use sky_science::direction::report_directions;
use sky_science::metrics::{SUN_EXCLUSION_DEG, is_clear_of_sun};
use sky_science::perez::plane_parallel_air_mass;
use sky_science::perez_sky::PEREZ_SCALE_HEIGHT_KM;
use sky_science::sky_model::{SkyError, SkyModel};

use crate::banded::{BandedSystem, NotPositive};
use crate::problem::{
    Channel, ChannelFit, FitError, FitOptions, Sample, SkySamples, Starts, fit_channel,
};

/// The nodes of a table and the form to fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Observer altitudes \[km\].
    pub altitude_km: Axis,
    /// Turbidities.
    pub turbidity: Axis,
    /// Sun zenith angles \[deg\].
    pub sun_zenith_deg: Axis,
    /// The sky formula.
    pub form: Form,
}

impl Grid {
    /// The report's grid: 5 altitudes, aerosol optical depths 0, 0.5 and 1, suns at 0, 45 and 90°.
    ///
    /// # Errors
    /// Never with these nodes.
    pub fn report() -> Result<Self, AxisError> {
        let t = sky_core::haze::turbidity_from_optical_depth_500;
        Ok(Self {
            altitude_km: Axis::new("km", vec![0.0, 6.0, 12.0, 20.0, 30.0])?,
            turbidity: Axis::new("1", vec![1.0, t(0.5), t(1.0)])?,
            sun_zenith_deg: Axis::new("deg", vec![0.0, 45.0, 90.0])?,
            form: Form::PerezReport,
        })
    }

    /// The default grid of the extended form: altitudes and turbidities where the haze is, suns near
    /// the horizon. Nodes were placed by the error between them and by how far the table bends at them,
    /// in at most 128 KiB.
    ///
    /// The second turbidity is where the stratospheric layer is complete and haze begins.
    ///
    /// # Errors
    /// Never with these nodes.
    pub fn extended() -> Result<Self, AxisError> {
        let haze_begins = sky_core::haze::turbidity_from_optical_depth_500(0.008_275_36);
        Ok(Self {
            altitude_km: Axis::new(
                "km",
                vec![
                    0.0, 0.45, 1.15, 2.2, 3.1, 4.0, 5.6, 7.6, 10.0, 13.5, 19.0, 24.5, 30.0,
                ],
            )?,
            turbidity: Axis::new("1", vec![1.0, haze_begins, 1.3, 2.0, 4.0, 8.0])?,
            sun_zenith_deg: Axis::new(
                "deg",
                vec![
                    0.0, 25.0, 52.0, 70.0, 79.5, 84.0, 86.7, 88.8, 90.5, 92.0, 94.0, 96.0,
                ],
            )?,
            form: Form::Extended,
        })
    }

    /// A grid of the spherical Perez form, for comparison: the default altitudes and suns, four
    /// turbidities.
    ///
    /// # Errors
    /// Never with these nodes.
    pub fn perez() -> Result<Self, AxisError> {
        Ok(Self {
            turbidity: Axis::new("1", vec![1.0, 2.0, 4.0, 8.0])?,
            form: Form::PerezSpherical,
            ..Self::extended()?
        })
    }

    /// Number of nodes.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.altitude_km.len() * self.turbidity.len() * self.sun_zenith_deg.len()
    }

    fn cells(&self) -> Vec<(f64, f64, f64)> {
        let mut cells = Vec::with_capacity(self.nodes());
        for altitude_km in self.altitude_km.nodes() {
            for turbidity in self.turbidity.nodes() {
                for sun_zenith_deg in self.sun_zenith_deg.nodes() {
                    cells.push((*altitude_km, *turbidity, *sun_zenith_deg));
                }
            }
        }
        cells
    }

    /// Sky maps that a sweep computes.
    #[must_use]
    pub fn maps(&self) -> usize {
        let [a, s] = match self.form {
            Form::Extended => [
                between(self.altitude_km.nodes()).len(),
                between(self.sun_zenith_deg.nodes()).len(),
            ],
            _ => [self.altitude_km.len(), self.sun_zenith_deg.len()],
        };
        a * s * self.turbidity.len()
    }
}

/// One node of the fitted grid, and how well the formula meets the sky there.
#[derive(Clone, Debug)]
pub struct NodeFit {
    /// Observer altitude \[km\].
    pub altitude_km: f64,
    /// Turbidity.
    pub turbidity: f64,
    /// Sun zenith angle \[deg\].
    pub sun_zenith_deg: f64,
    /// Fits of Y, x and y; empty for the extended form, whose fit is linear.
    pub channels: Vec<ChannelFit>,
}

/// A sky that a table was fitted to.
#[derive(Clone, Debug)]
pub struct SkyMap {
    /// Observer, haze and sun.
    pub conditions: Conditions,
    /// Directions, the sun's surroundings left out.
    pub directions: Vec<SkyDirection>,
    /// Their light.
    pub sky: Vec<Yxy>,
}

/// A fitted grid.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Values in the order of the table.
    pub values: Vec<f64>,
    /// The nodes, in the same order.
    pub nodes: Vec<NodeFit>,
    /// The skies that were fitted: at the nodes, and for the extended form between them.
    pub maps: Vec<SkyMap>,
}

impl SkyMap {
    /// The sky of an altitude \[km\], turbidity and sun zenith \[deg\], in the directions that the form
    /// is fitted in.
    ///
    /// # Errors
    /// When the sky does not cover the conditions.
    pub fn compute(
        truth: &dyn SkyModel,
        form: Form,
        (altitude_km, turbidity, sun_zenith_deg): (f64, f64, f64),
    ) -> Result<Self, SweepError> {
        let conditions = Conditions {
            observer_altitude: Length::from_km(altitude_km),
            turbidity,
            sun_zenith: Angle::from_degrees(sun_zenith_deg),
        };
        let mut directions = match form {
            Form::PerezReport => report_directions(),
            Form::PerezSpherical | Form::Extended => fit_directions(conditions.observer_altitude),
        };
        // Perez's formula has no room for what lies close to the sun
        if form != Form::Extended {
            let exclusion = Angle::from_degrees(SUN_EXCLUSION_DEG);
            directions.retain(|d| is_clear_of_sun(d, conditions.sun_zenith, exclusion));
        }
        let sky = truth.yxy_map(&conditions, &directions)?;
        Ok(Self {
            conditions,
            directions,
            sky,
        })
    }
}

/// Why a grid was not fitted.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The sky has no answer on the grid.
    #[error("grid: {0}")]
    Sky(#[from] SkyError),
    /// A channel that could not be fitted.
    #[error(
        "altitude {altitude_km} km, turbidity {turbidity}, sun zenith {sun_zenith_deg} deg: {source}"
    )]
    Fit {
        /// Observer altitude \[km\].
        altitude_km: f64,
        /// Turbidity.
        turbidity: f64,
        /// Sun zenith angle \[deg\].
        sun_zenith_deg: f64,
        /// What went wrong.
        source: FitError,
    },
    /// A fit that stopped before it converged.
    #[error(
        "altitude {altitude_km} km, turbidity {turbidity}, sun zenith {sun_zenith_deg} deg, {channel:?}: expected a converged fit, found {why:?}"
    )]
    NotConverged {
        /// Observer altitude \[km\].
        altitude_km: f64,
        /// Turbidity.
        turbidity: f64,
        /// Sun zenith angle \[deg\].
        sun_zenith_deg: f64,
        /// The channel.
        channel: Channel,
        /// Why the solver stopped.
        why: crate::solve::StopReason,
    },
    /// The linear fit of a turbidity has no solution.
    #[error("turbidity {turbidity}: {source}")]
    Linear {
        /// Turbidity.
        turbidity: f64,
        /// What went wrong.
        source: LinearFitError,
    },
}

/// Why maps give no table.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LinearFitError {
    /// A map that lies on no cell of the table: its light would be dropped.
    #[error("{quantity}: expected maps within {} to {}, found one at {found}", expected[0], expected[1])]
    Outside {
        /// The quantity, with its unit.
        quantity: &'static str,
        /// First and last node.
        expected: [f64; 2],
        /// The map's value.
        found: f64,
    },
    /// The maps do not determine the values.
    #[error(transparent)]
    Singular(#[from] NotPositive),
}

/// Directions that a table is fitted to at an altitude: denser towards the horizon and the sun's
/// azimuth, down to 0.25° above the geometric horizon.
#[must_use]
pub fn fit_directions(altitude: Length) -> Vec<SkyDirection> {
    const HIGH: [f64; 14] = [
        0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 75.0, 80.0, 83.0, 86.0, 88.0, 89.0,
    ];
    const AZIMUTHS: [f64; 13] = [
        0.0, 8.0, 16.0, 26.0, 40.0, 55.0, 72.0, 90.0, 110.0, 130.0, 150.0, 165.0, 180.0,
    ];
    let lowest = horizon_zenith(altitude).degrees() - 0.25;
    let low = (1..=6_u8).map(|k| 89.0 + (lowest - 89.0) * f64::from(k) / 6.0);
    HIGH.into_iter()
        .chain(low)
        .flat_map(|zenith| AZIMUTHS.map(|azimuth| SkyDirection::from_degrees(zenith, azimuth)))
        .collect()
}

/// Fits a grid to a sky. `done` is told of each map as it is computed.
///
/// # Errors
/// When the sky does not cover the grid or a node cannot be fitted; the node is named.
pub fn sweep(
    truth: &dyn SkyModel,
    grid: &Grid,
    done: &(dyn Fn() + Sync),
) -> Result<Sweep, SweepError> {
    match grid.form {
        Form::Extended => sweep_extended(truth, grid, done),
        Form::PerezReport | Form::PerezSpherical => sweep_perez(truth, grid, done),
    }
}

fn sweep_perez(
    truth: &dyn SkyModel,
    grid: &Grid,
    done: &(dyn Fn() + Sync),
) -> Result<Sweep, SweepError> {
    prepare(truth, grid)?;
    let fitted: Vec<(NodeFit, SkyMap)> = grid
        .cells()
        .par_iter()
        .map(|cell| {
            let map = SkyMap::compute(truth, grid.form, *cell)?;
            let node = fit_node(&map, grid.form, *cell)?;
            done();
            Ok((node, map))
        })
        .collect::<Result<_, SweepError>>()?;
    let (nodes, maps): (Vec<_>, Vec<_>) = fitted.into_iter().unzip();
    let values = nodes
        .iter()
        .flat_map(|node| &node.channels)
        .flat_map(|fit| core::iter::once(fit.zenith_value).chain(fit.coefficients.to_array()))
        .collect();
    Ok(Sweep {
        values,
        nodes,
        maps,
    })
}

/// The sky at the nodes of a grid, in the order of the table.
///
/// # Errors
/// When the sky does not cover the grid.
pub fn node_maps(
    truth: &dyn SkyModel,
    grid: &Grid,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<SkyMap>, SweepError> {
    prepare(truth, grid)?;
    grid.cells()
        .par_iter()
        .map(|cell| {
            let map = SkyMap::compute(truth, grid.form, *cell);
            done();
            map
        })
        .collect()
}

/// Lets the sky do its own parallel work for each turbidity before many threads ask for it.
fn prepare(truth: &dyn SkyModel, grid: &Grid) -> Result<(), SweepError> {
    for turbidity in grid.turbidity.nodes() {
        let conditions = Conditions {
            observer_altitude: Length::ZERO,
            turbidity: *turbidity,
            sun_zenith: Angle::ZERO,
        };
        truth.yxy_map(&conditions, &[SkyDirection::from_degrees(60.0, 0.0)])?;
    }
    Ok(())
}

/// What a fit of Perez's formula sees of a map.
fn samples(map: &SkyMap, form: Form, value: fn(&Yxy) -> f64) -> Vec<Sample> {
    let mass = |d: &SkyDirection| match form {
        Form::PerezReport => plane_parallel_air_mass(d.view_zenith.radians().cos()),
        _ => relative_air_mass(
            d.view_zenith.radians().cos(),
            map.conditions.observer_altitude,
            Length::from_km(PEREZ_SCALE_HEIGHT_KM),
        ),
    };
    map.directions
        .iter()
        .zip(&map.sky)
        .map(|(d, light)| Sample {
            air_mass: mass(d),
            scattering_angle: d.scattering_angle(map.conditions.sun_zenith),
            value: value(light),
            // solid angle, but never so little that the zenith or the horizon is forgotten
            weight: d.view_zenith.radians().sin().max(0.1),
        })
        .collect()
}

fn fit_node(
    map: &SkyMap,
    form: Form,
    (altitude_km, turbidity, sun_zenith_deg): (f64, f64, f64),
) -> Result<NodeFit, SweepError> {
    let mut channels = Vec::new();
    for (channel, value) in [
        (
            Channel::Luminance,
            (|y: &Yxy| y.luminance_cd_m2) as fn(&Yxy) -> f64,
        ),
        (Channel::ChromaticityX, |y| y.x),
        (Channel::ChromaticityY, |y| y.y),
    ] {
        let samples = samples(map, form, value);
        let sky = SkySamples {
            samples: &samples,
            sun_zenith: map.conditions.sun_zenith,
            zenith_air_mass: 1.0,
        };
        let fit = fit_channel(&sky, channel, Starts::Several, &FitOptions::default()).map_err(
            |source| SweepError::Fit {
                altitude_km,
                turbidity,
                sun_zenith_deg,
                source,
            },
        )?;
        if !fit.report.why_stopped.converged() {
            return Err(SweepError::NotConverged {
                altitude_km,
                turbidity,
                sun_zenith_deg,
                channel,
                why: fit.report.why_stopped,
            });
        }
        channels.push(fit);
    }
    Ok(NodeFit {
        altitude_km,
        turbidity,
        sun_zenith_deg,
        channels,
    })
}

/// Coefficients of the unit of regularization: what draws a coefficient to 0 where the sky does not
/// determine it, as residual per unit \[1\].
const RIDGE: f64 = 5e-4;

/// The nodes of an axis and the points half way between them.
#[must_use]
pub fn between(nodes: &[f64]) -> Vec<f64> {
    let mut all: Vec<f64> = nodes
        .windows(2)
        .flat_map(|w| [w[0], 0.5 * (w[0] + w[1])])
        .collect();
    all.extend(nodes.last());
    all
}

/// What one map adds to the joint fit of the extended form: the normal equations of its own fit.
#[derive(Clone, Debug)]
pub struct MapEquations {
    altitude_km: f64,
    sun_zenith_deg: f64,
    weight: f64,
    matrix: Vec<f64>,
    right: Vec<[f64; 3]>,
}

fn sweep_extended(
    truth: &dyn SkyModel,
    grid: &Grid,
    done: &(dyn Fn() + Sync),
) -> Result<Sweep, SweepError> {
    const K: usize = extended::TERMS;
    let (altitudes, suns) = (&grid.altitude_km, &grid.sun_zenith_deg);
    let (na, nt, ns) = (altitudes.len(), grid.turbidity.len(), suns.len());
    let mut values = vec![0.0; na * nt * ns * 3 * K];
    prepare(truth, grid)?;
    let mut maps = Vec::new();
    let mut places = Vec::new();
    for altitude_km in between(altitudes.nodes()) {
        for sun in between(suns.nodes()) {
            places.push((altitude_km, sun));
        }
    }
    for (t, turbidity) in grid.turbidity.nodes().iter().enumerate() {
        let computed: Vec<SkyMap> = places
            .par_iter()
            .map(|(altitude_km, sun)| {
                let map = SkyMap::compute(truth, grid.form, (*altitude_km, *turbidity, *sun));
                done();
                map
            })
            .collect::<Result<_, _>>()?;
        let equations: Vec<MapEquations> = computed
            .par_iter()
            .map(|map| MapEquations::of(map, 1.0))
            .collect();
        maps.extend(computed);
        let all: [usize; K] = core::array::from_fn(|k| k);
        let solution = fit_turbidity(&equations, altitudes, suns, &all).map_err(|source| {
            SweepError::Linear {
                turbidity: *turbidity,
                source,
            }
        })?;
        for (node, solved) in solution.chunks_exact(3 * K).enumerate() {
            let (a, s) = (node / ns, node % ns);
            values[((a * nt + t) * ns + s) * 3 * K..][..3 * K].copy_from_slice(solved);
        }
    }
    let nodes = grid
        .cells()
        .into_iter()
        .map(|(altitude_km, turbidity, sun_zenith_deg)| NodeFit {
            altitude_km,
            turbidity,
            sun_zenith_deg,
            channels: Vec::new(),
        })
        .collect();
    Ok(Sweep {
        values,
        nodes,
        maps,
    })
}

/// The values of a table at one turbidity, \[altitude\]\[sun zenith\]\[channel\]\[term\], fitted to
/// maps at any altitudes and suns at once: what is smallest is the error of the interpolated table.
/// `terms` are the places of the products in use.
///
/// # Errors
/// When a map lies outside the axes, or the maps do not determine the values.
pub fn fit_turbidity(
    maps: &[MapEquations],
    altitudes: &Axis,
    suns: &Axis,
    terms: &[usize],
) -> Result<Vec<f64>, LinearFitError> {
    let (na, ns, k) = (altitudes.len(), suns.len(), terms.len());
    // unknowns: sun, then altitude, then term: neighbors lie close together
    let mut system = BandedSystem::new(ns * na * k, (na + 2) * k);
    let mut block = vec![0.0; k * k];
    for map in maps {
        let altitude = corners_of("altitude [km]", altitudes, map.altitude_km)?;
        let sun = corners_of("sun zenith [deg]", suns, map.sun_zenith_deg)?;
        let corners: Vec<(usize, f64)> = sun
            .into_iter()
            .flat_map(|(s, ws)| altitude.map(move |(a, wa)| (s * na + a, ws * wa)))
            .filter(|(_, w)| *w > 0.0)
            .collect();
        for (row, i) in block.chunks_exact_mut(k).zip(terms) {
            for (to, j) in row.iter_mut().zip(terms) {
                *to = map.matrix[i * extended::TERMS + j];
            }
        }
        for (p, wp) in &corners {
            for (q, wq) in &corners {
                system.add_block(p * k, q * k, k, &block, map.weight * wp * wq);
            }
            for (row, i) in terms.iter().enumerate() {
                system.add_right(p * k + row, &map.right[*i].map(|r| r * map.weight * wp));
            }
        }
    }
    system.add_diagonal(RIDGE * RIDGE);
    let solution = system.solve()?;
    let mut values = vec![0.0; na * ns * 3 * k];
    for s in 0..ns {
        for a in 0..na {
            for i in 0..k {
                for (c, value) in solution[(s * na + a) * k + i].iter().enumerate() {
                    values[((a * ns + s) * 3 + c) * k + i] = *value;
                }
            }
        }
    }
    Ok(values)
}

/// The nodes around a value and their weights; an axis of one node has it for every value.
fn corners_of(
    quantity: &'static str,
    axis: &Axis,
    found: f64,
) -> Result<[(usize, f64); 2], LinearFitError> {
    if axis.len() == 1 {
        return Ok([(0, 1.0), (0, 0.0)]);
    }
    let cell = axis.cell_from_value(found).ok_or(LinearFitError::Outside {
        quantity,
        expected: axis.bounds(),
        found,
    })?;
    Ok([
        (cell.lower, 1.0 - cell.fraction),
        (cell.lower + 1, cell.fraction),
    ])
}

impl MapEquations {
    /// Of a map that counts for so many maps.
    #[must_use]
    pub fn of(map: &SkyMap, weight: f64) -> Self {
        const K: usize = extended::TERMS;
        let mut matrix = vec![0.0; K * K];
        let mut right = vec![[0.0; 3]; K];
        let mut used = 0.0;
        let brightest = map
            .sky
            .iter()
            .fold(0.0_f64, |most, light| most.max(light.luminance_cd_m2));
        for (d, light) in map.directions.iter().zip(&map.sky) {
            // a direction without light has no color to fit
            if light.luminance_cd_m2 <= 0.0 {
                continue;
            }
            let row = basis_in(d, &map.conditions);
            let target = [light.luminance_cd_m2.ln(), light.x, light.y];
            // twilight spans five orders of magnitude: what is seen counts for more than what is not
            let share = (light.luminance_cd_m2 / brightest).sqrt();
            used += share;
            for i in 0..K {
                for j in 0..K {
                    matrix[i * K + j] += share * row[i] * row[j];
                }
                for (right, target) in right[i].iter_mut().zip(target) {
                    *right += share * row[i] * target;
                }
            }
        }
        let share = if used > 0.0 { 1.0 / used } else { 0.0 };
        matrix.iter_mut().for_each(|m| *m *= share);
        right.iter_mut().flatten().for_each(|r| *r *= share);
        Self {
            altitude_km: map.conditions.observer_altitude.km(),
            sun_zenith_deg: map.conditions.sun_zenith.degrees(),
            weight,
            matrix,
            right,
        }
    }
}

/// The products for an observer and sun.
fn basis_in(direction: &SkyDirection, conditions: &Conditions) -> [f64; extended::TERMS] {
    extended::basis(
        single(direction.view_zenith.radians().cos()),
        extended::ScaledRadii::at(conditions.observer_altitude),
        single(direction.scattering_angle(conditions.sun_zenith).radians()),
        single(direction.cos_scattering_angle(conditions.sun_zenith)),
    )
    .map(f64::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the made-up sky has for the products: bent over altitude and sun, so that no node follows
    /// from its neighbors.
    fn coefficients(altitude_km: f64, sun_zenith_deg: f64) -> [[f64; 3]; extended::TERMS] {
        let (h, s) = (altitude_km / 30.0, sun_zenith_deg / 96.0);
        core::array::from_fn(|k| match k {
            0 => [5.0 - 3.0 * h * h + (4.0 * s).cos(), 0.3 + 0.02 * h, 0.32],
            1 => [0.7 * s * s, 0.01 * s, 0.0],
            2 => [1.0 - h * s, 0.0, 0.01 * h],
            _ => [0.0; 3],
        })
    }

    /// A map of that sky.
    fn map(altitude_km: f64, sun_zenith_deg: f64) -> SkyMap {
        let conditions = Conditions {
            observer_altitude: Length::from_km(altitude_km),
            turbidity: 2.0,
            sun_zenith: Angle::from_degrees(sun_zenith_deg),
        };
        let directions = fit_directions(conditions.observer_altitude);
        let all = coefficients(altitude_km, sun_zenith_deg);
        let sky = directions
            .iter()
            .map(|d| {
                let basis = basis_in(d, &conditions);
                let [ln_luminance, x, y] = core::array::from_fn(|c| {
                    basis.iter().zip(&all).map(|(b, k)| b * k[c]).sum::<f64>()
                });
                Yxy {
                    luminance_cd_m2: ln_luminance.exp(),
                    x,
                    y,
                }
            })
            .collect();
        SkyMap {
            conditions,
            directions,
            sky,
        }
    }

    /// The largest error of ln Y, x and y that a fitted node has on a map of its own.
    fn error(values: &[f64], map: &SkyMap) -> f64 {
        let mut worst: f64 = 0.0;
        for (d, light) in map.directions.iter().zip(&map.sky) {
            let basis = basis_in(d, &map.conditions);
            let want = [light.luminance_cd_m2.ln(), light.x, light.y];
            for (values, want) in values.chunks_exact(extended::TERMS).zip(want) {
                let found: f64 = basis.iter().zip(values).map(|(b, v)| b * v).sum();
                worst = worst.max((found - want).abs());
            }
        }
        worst
    }

    #[test]
    fn a5_every_node_of_a_table_meets_its_own_map_the_ends_too() {
        let grid = Grid::extended().unwrap();
        let (altitudes, suns) = (&grid.altitude_km, &grid.sun_zenith_deg);
        let places: Vec<(f64, f64)> = altitudes
            .nodes()
            .iter()
            .flat_map(|h| suns.nodes().iter().map(move |s| (*h, *s)))
            .collect();
        let maps: Vec<SkyMap> = places.iter().map(|(h, s)| map(*h, *s)).collect();
        let equations: Vec<MapEquations> = maps.iter().map(|m| MapEquations::of(m, 1.0)).collect();
        let all: [usize; extended::TERMS] = core::array::from_fn(|k| k);
        let values = fit_turbidity(&equations, altitudes, suns, &all).unwrap();
        for ((place, map), values) in places
            .iter()
            .zip(&maps)
            .zip(values.chunks_exact(3 * extended::TERMS))
        {
            let error = error(values, map);
            assert!(error < 1e-3, "{place:?}: {error}");
        }
    }

    #[test]
    fn a5_a_map_outside_the_table_is_an_error() {
        let axis = |nodes: &[f64]| Axis::new("1", nodes.to_vec()).unwrap();
        let all: [usize; extended::TERMS] = core::array::from_fn(|k| k);
        let fit = |altitude_km, sun_zenith_deg| {
            let equations = [MapEquations::of(&map(altitude_km, sun_zenith_deg), 1.0)];
            fit_turbidity(&equations, &axis(&[0.0, 10.0]), &axis(&[0.0, 90.0]), &all).err()
        };
        assert_eq!(fit(10.0, 90.0), None);
        assert!(matches!(
            fit(10.0, 90.1),
            Some(LinearFitError::Outside {
                quantity: "sun zenith [deg]",
                ..
            })
        ));
        assert!(matches!(
            fit(10.1, 90.0),
            Some(LinearFitError::Outside {
                quantity: "altitude [km]",
                ..
            })
        ));
    }
}
