//! Fisheye pictures of skies, as PNG in data addresses.
//!
//! Equidistant: the zenith in the middle, the geometric horizon at the rim, the sun above. The median
//! luminance of the truth's map is shown as middle gray, 18 % of white, and the fit is exposed alike. The
//! tone curve leaves colors up to three quarters of white as they are and bends above, so that a horizon
//! many times as bright as the zenith is not burnt white. Out of scope: the sun's disc.

use anyhow::Result;
use sky_core::color::{Yxy, linear_srgb_from_xyz, xyz_from_yxy};
use sky_core::conditions::Conditions;
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::quantity::{Angle, single};
use sky_core::tonemap::{Tone, encoded, tone_mapped};
use sky_plot::heat_map::heat_color;
use sky_plot::png::{byte, png, png_address};
use sky_science::metrics::{
    SUN_EXCLUSION_DEG, WHITE_PER_MEDIAN_LUMINANCE, ciede2000_of_lights, white_luminance,
};

/// Pixels across a picture.
const PIXELS: u16 = 168;

/// ΔE at the end of the scale of difference pictures.
pub const DIFFERENCE_FULL_SCALE: f64 = 5.0;

/// Share of white at which the median luminance is shown.
const MIDDLE_GRAY: f64 = 0.18;

/// Color of directions that are not compared: the sun's surroundings.
const LEFT_OUT: [u8; 3] = [128, 128, 128];

/// The grid on which skies are computed for pictures: zenith angles to just above the geometric
/// horizon and azimuths over half the circle, both closer near the sun's azimuth and the horizon.
#[derive(Clone, Debug)]
pub struct Grid {
    zenith: Vec<Angle>,
    azimuth: Vec<Angle>,
}

const ZENITHS: u8 = 34;
const AZIMUTHS: u8 = 31;

impl Grid {
    /// For an observer.
    #[must_use]
    pub fn new(conditions: &Conditions) -> Self {
        let end = horizon_zenith(conditions.observer_altitude).degrees() - 0.1;
        // s is 0–1; 1.6 s − 0.6 s² closes up towards 1, s² towards 0.
        let zenith = (0..ZENITHS).map(|i| {
            let s = f64::from(i) / f64::from(ZENITHS - 1);
            Angle::from_degrees(end * (1.6 * s - 0.6 * s * s))
        });
        let azimuth = (0..AZIMUTHS).map(|i| {
            let s = f64::from(i) / f64::from(AZIMUTHS - 1);
            Angle::from_degrees(180.0 * (0.5 * s + 0.5 * s * s))
        });
        Self {
            zenith: zenith.collect(),
            azimuth: azimuth.collect(),
        }
    }

    /// Ring by ring.
    #[must_use]
    pub fn directions(&self) -> Vec<SkyDirection> {
        let ring = |view_zenith| {
            self.azimuth
                .iter()
                .map(move |&relative_azimuth| SkyDirection {
                    view_zenith,
                    relative_azimuth,
                })
        };
        self.zenith.iter().flat_map(|&z| ring(z)).collect()
    }

    /// The map in a direction, bilinear between the grid's directions.
    fn at(&self, map: &[[f64; 3]], zenith: f64, azimuth: f64) -> [f64; 3] {
        let (i, s) = locate(&self.zenith, zenith);
        let (j, t) = locate(&self.azimuth, azimuth);
        let n = self.azimuth.len();
        let corner = |di: usize, dj: usize| map[(i + di) * n + j + dj];
        let (a, b, c, d) = (corner(0, 0), corner(0, 1), corner(1, 0), corner(1, 1));
        core::array::from_fn(|k| {
            (1.0 - s) * ((1.0 - t) * a[k] + t * b[k]) + s * ((1.0 - t) * c[k] + t * d[k])
        })
    }
}

fn locate(nodes: &[Angle], value: f64) -> (usize, f64) {
    let i = nodes.partition_point(|node| node.radians() <= value);
    let i = i.saturating_sub(1).min(nodes.len() - 2);
    let (low, high) = (nodes[i].radians(), nodes[i + 1].radians());
    (i, ((value - low) / (high - low)).clamp(0.0, 1.0))
}

/// Truth, fit and their difference as data addresses.
///
/// # Errors
/// When a picture cannot be encoded.
pub fn triple(
    conditions: &Conditions,
    grid: &Grid,
    truth: &[Yxy],
    fit: Option<&[Yxy]>,
) -> Result<[Option<String>; 3]> {
    let address =
        |tile: Vec<u8>| -> Result<String> { Ok(png_address(&png(&tile, [PIXELS.into(); 2])?)) };
    let [truth, fit, difference] = tiles(conditions, grid, truth, fit);
    Ok([
        truth.map(address).transpose()?,
        fit.map(address).transpose()?,
        difference.map(address).transpose()?,
    ])
}

/// Truth, another sky and their difference side by side, as a PNG file.
///
/// # Errors
/// When it cannot be encoded.
pub fn strip(
    conditions: &Conditions,
    grid: &Grid,
    truth: &[Yxy],
    other: &[Yxy],
) -> Result<Vec<u8>> {
    let tiles = tiles(conditions, grid, truth, Some(other));
    let row_bytes = 4 * usize::from(PIXELS);
    let rows = (0..usize::from(PIXELS)).flat_map(|row| {
        let of_tile = move |tile: &Vec<u8>| tile[row * row_bytes..(row + 1) * row_bytes].to_vec();
        tiles.iter().flatten().flat_map(of_tile)
    });
    Ok(png(
        &rows.collect::<Vec<u8>>(),
        [3 * u32::from(PIXELS), PIXELS.into()],
    )?)
}

/// Truth, fit and their difference, as pixels with alpha.
fn tiles(
    conditions: &Conditions,
    grid: &Grid,
    truth: &[Yxy],
    fit: Option<&[Yxy]>,
) -> [Option<Vec<u8>>; 3] {
    let white = white_luminance(truth).unwrap_or(1.0);
    let exposure = MIDDLE_GRAY * WHITE_PER_MEDIAN_LUMINANCE / white;
    let linear = |map: &[Yxy]| -> Vec<[f64; 3]> {
        map.iter()
            .map(|&c| {
                let rgb = linear_srgb_from_xyz(xyz_from_yxy(c));
                [rgb.red, rgb.green, rgb.blue].map(|c| c * exposure)
            })
            .collect()
    };
    let developed = |map: &[Yxy]| {
        render(conditions, grid, &linear(map), |rgb, _| {
            tone_mapped(rgb.map(single), Tone::Neutral).map(|c| byte(encoded(c).into()))
        })
    };
    let difference = |fit: &[Yxy]| {
        let errors: Vec<[f64; 3]> = truth
            .iter()
            .zip(fit)
            .map(|(t, f)| [ciede2000_of_lights(*f, *t, white); 3])
            .collect();
        render(conditions, grid, &errors, |[delta_e, _, _], direction| {
            let gamma = direction.scattering_angle(conditions.sun_zenith);
            if gamma.degrees() < SUN_EXCLUSION_DEG {
                LEFT_OUT
            } else {
                heat_color(delta_e / DIFFERENCE_FULL_SCALE)
            }
        })
    };
    [
        Some(developed(truth)),
        fit.map(developed),
        fit.map(difference),
    ]
}

fn render(
    conditions: &Conditions,
    grid: &Grid,
    map: &[[f64; 3]],
    color: impl Fn([f64; 3], &SkyDirection) -> [u8; 3],
) -> Vec<u8> {
    let rim = horizon_zenith(conditions.observer_altitude).radians();
    let radius = 0.5 * f64::from(PIXELS);
    let mut pixels = Vec::with_capacity(usize::from(PIXELS) * usize::from(PIXELS) * 4);
    for row in 0..PIXELS {
        for column in 0..PIXELS {
            // To the right and towards the sun, in radii.
            let right = (f64::from(column) + 0.5) / radius - 1.0;
            let sunward = 1.0 - (f64::from(row) + 0.5) / radius;
            let distance = right.hypot(sunward);
            let zenith = rim * distance.min(1.0);
            let azimuth = right.abs().atan2(sunward);
            let direction = SkyDirection {
                view_zenith: Angle::from_radians(zenith),
                relative_azimuth: Angle::from_radians(azimuth),
            };
            pixels.extend(color(grid.at(map, zenith, azimuth), &direction));
            // Soft over the last pixel.
            pixels.push(byte((1.0 - distance) * radius));
        }
    }
    pixels
}
