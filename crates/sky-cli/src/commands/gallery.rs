//! `utm-sky gallery`: the report's Figures 5.1–5.7 as one contact sheet, drawn by our model.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster};
use sky_core::color::{LinearSrgb, linear_srgb_from_xyz, xyz_from_yxy};
use sky_core::direction::SkyDirection;
use sky_core::picture::Picture;
use sky_core::quantity::{Angle, single};
use sky_core::tonemap::{Tone, encoded, exposure_from_ev100, tone_mapped};
use sky_core::utm_sky::UtmSky;
use sky_eval::cases::conditions;
use sky_eval::progress::Progress as _;
use sky_eval::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};
use sky_gpu::{Camera, Tier, auto_ev100};
use sky_plot::png::png_address;
use sky_render::pixels::byte;
use sky_render::{GROUND_ALBEDO, Painter, Pixels, Scenery, Shot, draw_on_cpu, file_bytes, looking};
use sky_science::sky_model::SkyModel as _;
use sky_sim::optics::{Constituents, OpticsSettings};
use sky_sim::profile::AtmosphereProfile;

use crate::args::{Backend, LutSource, lut_source};
use crate::io::files::{OutputFile, create_directory};
use crate::io::lut::load;
use crate::io::progress::Bars;

/// `utm-sky gallery`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  utm-sky gallery --out gallery

Writes gallery.png, one contact sheet with captions, and gallery.html, the same as a page.")]
pub struct GalleryArgs {
    /// Look-up table: a .utmlut file, a plan (.toml), which is baked first, or the built-in one
    #[arg(long, value_name = "FILE|embedded", default_value = "embedded", value_parser = lut_source)]
    pub lut: LutSource,
    /// Who draws
    #[arg(long, value_enum, default_value_t)]
    pub backend: Backend,
    /// Directory
    #[arg(long, value_name = "DIR", default_value = "target/utm-sky/gallery")]
    pub out: PathBuf,
}

/// Pixels of a panel.
const SIZE: [u32; 2] = [400, 225];
/// Panels in a row of the sheet.
const COLUMNS: u32 = 3;
/// Pixels between panels.
const GAP: u32 = 6;
/// Pixels below a panel for its caption, two lines.
const CAPTION: u32 = 2 * LINE + 6;
const LINE: u32 = 18;

/// One panel: figure, caption, altitude \[km\], turbidity, sun zenith \[deg\], where the camera looks
/// from the sun (azimuth, elevation) \[deg\], vertical field of view \[deg\].
struct Panel {
    figure: &'static str,
    caption: &'static str,
    place: [f64; 3],
    look: [f64; 2],
    fov_deg: f64,
    kind: Kind,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Sky,
    Terrain,
    BareTerrain,
    WithoutOzone,
}

const fn panel(
    figure: &'static str,
    caption: &'static str,
    place: [f64; 3],
    look: [f64; 2],
    fov_deg: f64,
    kind: Kind,
) -> Panel {
    Panel {
        figure,
        caption,
        place,
        look,
        fov_deg,
        kind,
    }
}

const PANELS: [Panel; 18] = [
    panel(
        "5.1",
        "low sun, 86° from the zenith",
        [0.0, 1.5, 86.0],
        [0.0, 18.0],
        60.0,
        Kind::Sky,
    ),
    panel(
        "5.1",
        "high sun, 30°",
        [0.0, 1.5, 30.0],
        [0.0, 25.0],
        60.0,
        Kind::Sky,
    ),
    panel(
        "5.1",
        "sun just set, 91°",
        [0.0, 1.5, 91.0],
        [0.0, 18.0],
        60.0,
        Kind::Sky,
    ),
    panel(
        "5.2",
        "low turbidity, T 1.3",
        [0.0, 1.3, 60.0],
        [70.0, 22.0],
        60.0,
        Kind::Sky,
    ),
    panel(
        "5.2",
        "high turbidity, T 7",
        [0.0, 7.0, 60.0],
        [70.0, 22.0],
        60.0,
        Kind::Sky,
    ),
    panel(
        "5.3",
        "the aureole, T 4",
        [0.0, 4.0, 60.0],
        [0.0, 30.0],
        40.0,
        Kind::Sky,
    ),
    panel(
        "5.4",
        "from 0 km",
        [0.0, 2.0, 60.0],
        [120.0, 30.0],
        75.0,
        Kind::Sky,
    ),
    panel(
        "5.4",
        "from 5 km",
        [5.0, 2.0, 60.0],
        [120.0, 30.0],
        75.0,
        Kind::Sky,
    ),
    panel(
        "5.4",
        "from 10 km",
        [10.0, 2.0, 60.0],
        [120.0, 30.0],
        75.0,
        Kind::Sky,
    ),
    panel(
        "5.4",
        "from 20 km",
        [20.0, 2.0, 60.0],
        [120.0, 30.0],
        75.0,
        Kind::Sky,
    ),
    panel(
        "5.4",
        "from 30 km",
        [30.0, 2.0, 60.0],
        [120.0, 30.0],
        75.0,
        Kind::Sky,
    ),
    panel(
        "5.5",
        "terrain with aerial perspective",
        [4.0, 2.0, 50.0],
        [60.0, -4.0],
        45.0,
        Kind::Terrain,
    ),
    panel(
        "5.5",
        "terrain without",
        [4.0, 2.0, 50.0],
        [60.0, -4.0],
        45.0,
        Kind::BareTerrain,
    ),
    panel(
        "5.5",
        "terrain from 12 km",
        [12.0, 3.0, 75.0],
        [40.0, -6.0],
        45.0,
        Kind::Terrain,
    ),
    panel(
        "5.6",
        "sun at 90°: the zenith is blue",
        [0.0, 1.2, 90.0],
        [180.0, 75.0],
        60.0,
        Kind::Sky,
    ),
    panel(
        "5.6",
        "the same without ozone",
        [0.0, 1.2, 90.0],
        [180.0, 75.0],
        60.0,
        Kind::WithoutOzone,
    ),
    panel(
        "5.7",
        "no dark band 90° from the sun",
        [0.0, 2.0, 88.0],
        [0.0, 75.0],
        110.0,
        Kind::Sky,
    ),
    panel(
        "5.7",
        "dusk from 12 km, sun at 93°",
        [12.0, 2.0, 93.0],
        [0.0, 5.0],
        60.0,
        Kind::Sky,
    ),
];

/// Runs the command.
///
/// # Errors
/// When the table cannot be read, there is no GPU or a file cannot be written.
pub fn run(args: &GalleryArgs) -> Result<()> {
    let sky = UtmSky::new(load(&args.lut)?)?;
    create_directory(&args.out)?;
    let sheet_file = OutputFile::create(&args.out.join("gallery.png"))?;
    let page_file = OutputFile::create(&args.out.join("gallery.html"))?;
    let mut painter = match args.backend {
        Backend::Gpu => Some(Painter::new(sky.clone())?),
        Backend::Cpu => None,
    };
    let bars = Bars::new();
    bars.begin("panels", Some(PANELS.len()));
    let rows = u32::try_from(PANELS.len())?.div_ceil(COLUMNS);
    let size = [
        COLUMNS * (SIZE[0] + GAP) + GAP,
        rows * (SIZE[1] + CAPTION + GAP) + GAP,
    ];
    let mut sheet = vec![255_u8; 3 * (size[0] * size[1]) as usize];
    let mut figures = String::new();
    for (i, panel) in (0..).zip(&PANELS) {
        let shot = shot(panel);
        let pixels = if panel.kind == Kind::WithoutOzone {
            without_ozone(&sky, &shot)?
        } else if let Some(painter) = &mut painter {
            painter.draw(&shot)?
        } else {
            draw_on_cpu(&sky, &shot)?
        };
        let corner = [
            GAP + i % COLUMNS * (SIZE[0] + GAP),
            GAP + i / COLUMNS * (SIZE[1] + CAPTION + GAP),
        ];
        paste(&mut sheet, size[0], &pixels, corner);
        let [altitude, turbidity, sun] = panel.place;
        let words = [
            format!("{} {}", panel.figure, panel.caption),
            format!("    {altitude} km, T {turbidity}, sun {sun}°"),
        ];
        for (line, words) in (0..).zip(&words) {
            let top = corner[1] + SIZE[1] + 3 + line * LINE;
            write(&mut sheet, size[0], words, [corner[0], top]);
        }
        writeln!(
            figures,
            "<figure><img src=\"{}\" alt=\"\"><figcaption>Figure {}: {}. {altitude} km, T {turbidity}, \
             sun {sun}°</figcaption></figure>",
            png_address(&file_bytes(&pixels, SIZE)?),
            panel.figure,
            panel.caption
        )?;
        bars.step();
    }
    bars.end();
    sheet_file.commit(&file_bytes(&Pixels::Srgb8(sheet), size)?)?;
    page_file.commit(
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>UTM sky gallery</title>\
             <style>body{{font:15px system-ui,sans-serif;margin:24px;display:flex;flex-wrap:wrap;gap:14px}}\
             figure{{margin:0;max-width:400px}}figcaption{{color:#555}}</style></head><body>\n{figures}</body></html>\n"
        )
        .as_bytes(),
    )?;
    Ok(())
}

fn shot(panel: &Panel) -> Shot {
    let [altitude, turbidity, sun] = panel.place;
    let [azimuth, elevation] = panel.look;
    Shot {
        conditions: conditions(altitude, turbidity, sun),
        sun_azimuth: Angle::ZERO,
        camera: Camera {
            depth_is_distance: true,
            ..Camera::perspective(
                single(Angle::from_degrees(panel.fov_deg).radians()),
                16.0 / 9.0,
                looking(azimuth, elevation),
            )
        },
        size: SIZE,
        ev100: None,
        tone: Some(Tone::Neutral),
        tier: Tier::Fragment,
        sun_disc: true,
        scenery: match panel.kind {
            Kind::Terrain | Kind::BareTerrain => Scenery::Terrain,
            Kind::Sky | Kind::WithoutOzone => Scenery::None,
        },
        aerial: panel.kind != Kind::BareTerrain,
    }
}

/// The transport engine's own sky without ozone, under the exposure of the table's with ozone.
fn without_ozone(sky: &UtmSky, shot: &Shot) -> Result<Pixels> {
    let settings = OpticsSettings {
        constituents: Constituents {
            ozone: false,
            ..Constituents::REFERENCE
        },
        ..OpticsSettings::with_step_nm(10)?
    };
    let engine = TransportSky::new(
        AtmosphereProfile::general(),
        settings,
        DEFAULT_GROUND_ALBEDO,
    )?;
    let picture = Picture::new(sky, &shot.conditions, GROUND_ALBEDO)?;
    let exposure = exposure_from_ev100(auto_ev100(&picture));
    let axes = shot.frame().local_axes();
    let directions: Vec<SkyDirection> = (0..SIZE[1])
        .flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)))
        .filter_map(|(x, y)| shot.direction(x, y))
        .map(|world| SkyDirection::from_vector(axes.map(|a| f64::from(a.dot(world)))))
        .collect();
    let lights = engine.yxy_map(&shot.conditions, &directions)?;
    Ok(Pixels::Srgb8(
        lights
            .into_iter()
            .flat_map(|light| {
                let LinearSrgb { red, green, blue } = linear_srgb_from_xyz(xyz_from_yxy(light));
                tone_mapped(
                    [red, green, blue].map(|c| single(c) * exposure),
                    Tone::Neutral,
                )
                .map(|c| byte(encoded(c)))
            })
            .collect(),
    ))
}

/// Writes a line into the sheet, dark on white.
fn write(sheet: &mut [u8], width: u32, words: &str, [left, top]: [u32; 2]) {
    let letters = words
        .chars()
        .filter_map(|c| get_raster(c, FontWeight::Regular, RasterHeight::Size16));
    let mut x = left;
    for letter in letters {
        for (y, row) in (top..).zip(letter.raster()) {
            for (x, ink) in (x..).zip(*row) {
                let start = 3 * (y * width + x) as usize;
                sheet[start..start + 3].fill(255 - ink);
            }
        }
        x += u32::try_from(letter.width()).unwrap_or(0);
    }
}

/// Copies a panel into the sheet.
fn paste(sheet: &mut [u8], width: u32, pixels: &Pixels, [left, top]: [u32; 2]) {
    let Pixels::Srgb8(bytes) = pixels else {
        return;
    };
    let row = 3 * SIZE[0] as usize;
    for (y, line) in (top..).zip(bytes.chunks_exact(row)) {
        let start = 3 * (y * width + left) as usize;
        sheet[start..start + row].copy_from_slice(line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn d_every_caption_fits_below_its_panel() {
        for panel in &PANELS {
            let words = format!("{} {}", panel.figure, panel.caption);
            let letters: Vec<_> = words
                .chars()
                .map(|c| {
                    get_raster(c, FontWeight::Regular, RasterHeight::Size16)
                        .unwrap_or_else(|| panic!("{c:?} cannot be written"))
                })
                .collect();
            let width: usize = letters.iter().map(|letter| letter.width()).sum();
            assert!(width <= SIZE[0] as usize, "{words}: {width} px");
            assert!(letters.iter().all(|l| l.height() <= LINE as usize));
        }
    }
}
