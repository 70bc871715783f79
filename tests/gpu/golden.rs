//! Pictures against those that were looked at and kept in `golden/`. Needs a Vulkan driver; a software
//! one will do.
//!
//! A missing reference is a failure. References are written only when asked for, and never with CI
//! set:
//!
//! ```text
//! UTM_SKY_BLESS=1 cargo test --release -p sky-tests --test gpu golden
//! ```
//!
//! What is wrong with a picture that was blessed, only an eye sees: look at it first.

#![expect(
    clippy::print_stdout,
    reason = "the measured figures are part of the test's answer"
)]

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use sky_core::quantity::Angle;
use sky_core::tonemap::Tone;
use sky_eval::cases::conditions;
use sky_gpu::{Camera, Dome, Projection, Tier};
use sky_render::Scenery;
use sky_render::{Pixels, Shot, facing, file_bytes, looking};

use crate::gpu::painter;

/// Largest difference of a channel, in steps of 8 bits: software drivers differ by 1 among themselves,
/// and the dither turns a last bit into a step.
const TOLERANCE: u8 = 2;
/// One pixel in this many may differ by more: those whose center lies on an edge (the sun's disc, the
/// horizon, a ridge), or where the tone curve has a corner (the desaturation begins at the display's
/// limits). There a last bit of `f32` decides which side is drawn.
const PIXELS_OF_A_STRAY: usize = 1000;

const SIZE: [u32; 2] = [128, 72];
const SUN_AZIMUTH_DEG: f64 = 20.0;
/// Shows the sky of a clear noon as an eye adapted to the ground sees it; for the pictures from above,
/// so that they can be compared.
const DAYLIGHT: Option<f32> = Some(14.0);

/// Altitude \[km\], turbidity, sun zenith angle \[deg\].
type Place = [f64; 3];

struct Golden {
    name: &'static str,
    place: Place,
    camera: Camera,
    tier: Tier,
    ev100: Option<f32>,
    /// Terrain, with or without the air before it.
    terrain: Option<bool>,
}

/// A camera at an azimuth from the sun and an elevation \[deg\], with a vertical field of view \[rad\].
fn view(from_sun: f64, elevation: f64, field_of_view: f32) -> Camera {
    Camera {
        depth_is_distance: true,
        ..Camera::perspective(
            field_of_view,
            16.0 / 9.0,
            looking(SUN_AZIMUTH_DEG + from_sun, elevation),
        )
    }
}

fn goldens() -> Vec<Golden> {
    let golden = |name, place, camera, tier| Golden {
        name,
        place,
        camera,
        tier,
        ev100: None,
        terrain: None,
    };
    let aloft = |name, place, camera, tier| Golden {
        ev100: DAYLIGHT,
        ..golden(name, place, camera, tier)
    };
    let terrain = |name, tier, air| Golden {
        terrain: Some(air),
        ..golden(name, [5.0, 3.0, 60.0], view(70.0, -3.0, 0.8), tier)
    };
    let fisheye = Camera::panorama(
        Projection::Fisheye { aspect: 16.0 / 9.0 },
        facing(SUN_AZIMUTH_DEG),
    );
    let equirect = Camera::panorama(Projection::Equirectangular, facing(SUN_AZIMUTH_DEG));
    let (fragment, baked) = (Tier::Fragment, Tier::Baked);
    vec![
        aloft(
            "noon_clear",
            [0.0, 1.8, 35.0],
            view(100.0, 20.0, 1.1),
            fragment,
        ),
        aloft("noon_hazy", [0.0, 7.0, 35.0], view(100.0, 20.0, 1.1), baked),
        golden("sun_80", [0.0, 2.5, 80.0], view(0.0, 12.0, 1.1), fragment),
        golden("sun_88", [0.0, 3.3, 88.0], view(0.0, 12.0, 1.1), baked),
        golden("sunset", [0.0, 2.5, 90.0], view(0.0, 12.0, 1.1), fragment),
        golden("belt", [0.0, 2.5, 92.0], view(180.0, 12.0, 1.1), baked),
        golden(
            "zenith",
            [0.0, 2.5, 60.0],
            view(0.0, 90.0, 1.9),
            Tier::Vertex(Dome::FINE),
        ),
        terrain("terrain_5_km", fragment, true),
        terrain("terrain_5_km_no_air", baked, false),
        aloft("12_km", [12.0, 1.8, 35.0], view(100.0, 20.0, 1.1), baked),
        golden(
            "fisheye_20_km",
            [20.0, 2.0, 70.0],
            fisheye,
            Tier::Vertex(Dome::REPORT),
        ),
        aloft("equirect_30_km", [30.0, 1.8, 60.0], equirect, fragment),
    ]
}

impl Golden {
    fn shot(&self) -> Shot {
        let [altitude_km, turbidity, sun_deg] = self.place;
        Shot {
            conditions: conditions(altitude_km, turbidity, sun_deg),
            sun_azimuth: Angle::from_degrees(SUN_AZIMUTH_DEG),
            camera: self.camera,
            size: SIZE,
            ev100: self.ev100,
            tone: Some(Tone::Neutral),
            tier: self.tier,
            scenery: self.terrain.map_or(Scenery::None, |_| Scenery::Terrain),
            sun_disc: true,
            aerial: self.terrain.unwrap_or(true),
        }
    }

    fn file(&self) -> String {
        format!("{}.png", self.name)
    }
}

/// Red, green and blue of a picture, row by row.
#[derive(Clone)]
struct Image {
    size: [u32; 2],
    bytes: Vec<u8>,
}

impl Image {
    fn drawn(shot: &Shot) -> Self {
        match painter().draw(shot).expect("a picture") {
            Pixels::Srgb8(bytes) => Self {
                size: shot.size,
                bytes,
            },
            Pixels::Linear(_) => panic!("an 8-bit picture was asked for"),
        }
    }

    fn read(path: &Path) -> Result<Self, String> {
        let bytes = fs::read(path).map_err(|e| {
            format!(
                "{}: expected the reference, found {e}; it is written with UTM_SKY_BLESS=1, without CI",
                path.display()
            )
        })?;
        let picture = image::load_from_memory(&bytes)
            .map_err(|e| format!("{}: expected a PNG file, found {e}", path.display()))?
            .into_rgb8();
        Ok(Self {
            size: [picture.width(), picture.height()],
            bytes: picture.into_raw(),
        })
    }

    fn write(&self, path: &Path) {
        let bytes = file_bytes(&Pixels::Srgb8(self.bytes.clone()), self.size).expect("a PNG file");
        fs::write(path, bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    }

    /// Largest difference of a channel, by pixel.
    fn differences(&self, other: &Self) -> Vec<u8> {
        let channels = |p: &Self| p.bytes.clone().into_iter();
        let by_channel: Vec<u8> = channels(self)
            .zip(channels(other))
            .map(|(a, b)| a.abs_diff(b))
            .collect();
        by_channel
            .chunks_exact(3)
            .map(|p| p[0].max(p[1]).max(p[2]))
            .collect()
    }

    /// Largest difference and number of strays.
    fn agrees_with(&self, reference: &Self) -> Result<(u8, usize), String> {
        if self.size != reference.size || self.bytes.len() != reference.bytes.len() {
            return Err(format!(
                "expected {:?} pixels, found {:?}",
                reference.size, self.size
            ));
        }
        let differences = self.differences(reference);
        let worst = differences.iter().copied().max().unwrap_or(0);
        let strays = differences.iter().filter(|d| **d > TOLERANCE).count();
        let allowed = differences.len() / PIXELS_OF_A_STRAY;
        if strays > allowed {
            return Err(format!(
                "expected at most {allowed} pixels that differ by more than {TOLERANCE}/255, found \
                 {strays}, the worst by {worst}"
            ));
        }
        Ok((worst, strays))
    }
}

fn references() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("golden")
}

/// Whether references are to be written, by the variables `UTM_SKY_BLESS` and `CI`.
fn blessing(bless: Option<&OsStr>, ci: Option<&OsStr>) -> Result<bool, &'static str> {
    match (bless, ci) {
        (Some(_), Some(_)) => Err("UTM_SKY_BLESS: expected unset where CI is set"),
        (Some(value), None) if value != "1" => Err("UTM_SKY_BLESS: expected 1 or unset"),
        (bless, _) => Ok(bless.is_some()),
    }
}

#[test]
fn pictures_are_those_that_were_kept() {
    let [bless, ci] = ["UTM_SKY_BLESS", "CI"].map(std::env::var_os);
    let bless = blessing(bless.as_deref(), ci.as_deref()).unwrap_or_else(|e| panic!("{e}"));
    let mut wrong = Vec::new();
    for golden in goldens() {
        let found = Image::drawn(&golden.shot());
        let path = references().join(golden.file());
        if bless {
            found.write(&path);
        }
        match Image::read(&path).and_then(|reference| found.agrees_with(&reference)) {
            Ok((worst, strays)) => println!("{}: worst {worst}/255, {strays} strays", golden.name),
            Err(error) => {
                let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join(golden.file());
                found.write(&place);
                wrong.push(format!(
                    "{}: {error}; found: {}",
                    golden.name,
                    place.display()
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn every_kept_picture_is_drawn_and_small() {
    let drawn: BTreeSet<String> = goldens().iter().map(Golden::file).collect();
    let mut kept = BTreeSet::new();
    for entry in fs::read_dir(references()).expect("references") {
        let entry = entry.expect("an entry");
        let bytes = entry.metadata().expect("a file").len();
        assert!(
            bytes <= 24 * 1024,
            "{}: {bytes} bytes",
            entry.path().display()
        );
        kept.insert(entry.file_name().to_string_lossy().into_owned());
    }
    assert_eq!(kept, drawn);
    assert_eq!(kept.len(), 12);
}

#[test]
fn a_missing_reference_is_an_error_and_blessing_is_asked_for() {
    let Err(error) = Image::read(&references().join("none.png")) else {
        panic!("no such file");
    };
    assert!(error.contains("expected the reference"), "{error}");
    let (set, other) = (Some(OsStr::new("1")), Some(OsStr::new("yes")));
    assert_eq!(blessing(None, None), Ok(false));
    assert_eq!(blessing(None, set), Ok(false));
    assert_eq!(blessing(set, None), Ok(true));
    assert!(blessing(other, None).is_err());
    for ci in [set, other, Some(OsStr::new(""))] {
        assert!(blessing(set, ci).is_err());
    }
}

/// The harness sees what it is there to see: a difference of 4/255 in one channel, all over or in a few
/// pixels; it lets pass what a driver may do.
#[test]
fn a_picture_altered_by_four_steps_is_refused() {
    for golden in goldens() {
        let kept = Image::read(&references().join(golden.file())).unwrap_or_else(|e| panic!("{e}"));
        let pixels = kept.bytes.len() / 3;
        // every `stride`-th pixel of a channel
        let altered = |channel: usize, stride: usize, steps: u8| {
            let mut picture = kept.clone();
            for pixel in picture.bytes.chunks_exact_mut(3).step_by(stride) {
                let value = &mut pixel[channel];
                *value = value.checked_add(steps).unwrap_or(*value - steps);
            }
            picture
        };
        for channel in 0..3 {
            for stride in [1, 100, 900] {
                let refused = altered(channel, stride, 4).agrees_with(&kept);
                assert!(refused.is_err(), "{}: {refused:?}", golden.name);
            }
            let few = altered(channel, pixels / 9 + 1, 4).agrees_with(&kept);
            assert_eq!(few, Ok((4, 9)), "{}", golden.name);
            let driver = altered(channel, 1, TOLERANCE).agrees_with(&kept);
            assert_eq!(driver, Ok((TOLERANCE, 0)), "{}", golden.name);
        }
        let cut = Image {
            size: [SIZE[0], SIZE[1] - 1],
            bytes: kept.bytes[3 * SIZE[0] as usize..].to_vec(),
        };
        assert!(cut.agrees_with(&kept).is_err());
    }
}
