//! Pictures of the sky, and the paths of its colors as the sun sets.

use anyhow::Result;
use sky_core::color::Yxy;
use sky_core::conditions::Conditions;
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_science::metrics::white_luminance;
use sky_science::sky_model::SkyModel;

use super::appendix_a::spectral_locus;
use super::input::ReportInput;
use super::long_table::LongTable;
use crate::cases::conditions;
use crate::picture::{DIFFERENCE_FULL_SCALE, Grid, triple};
use sky_plot::Scale;
use sky_plot::chart::{Chart, Note, Series, Stroke};
use sky_plot::heat_map::color_bar;
use sky_plot::number::short;
use sky_plot::page::{Section, escape};

pub(super) fn pictures(input: &ReportInput<'_>) -> Result<Section> {
    let settings = input.settings;
    let fit = &input.fits[0];
    let mut body = format!(
        "<p>The whole sky at turbidity {}, zenith in the middle, geometric horizon at the rim, sun \
         towards the top: <b>truth | {} | difference</b>. The median luminance of the truth \
         (the figure in the caption) is shown as middle gray, the fit alike. The difference is ΔE; \
         gray is the sun's 5°, which no comparison counts.</p>\n{}<div class=\"grid skies\">",
        short(settings.scene_turbidity),
        escape(&fit.name),
        color_bar(DIFFERENCE_FULL_SCALE, "ΔE")
    );
    for &km in &settings.picture_altitudes_km {
        body.push_str(&format!(
            "</div><h3>{} km</h3>\n<div class=\"grid\">",
            short(km)
        ));
        for &sun in &settings.picture_suns_deg {
            let here = conditions(km, settings.scene_turbidity, sun);
            let grid = Grid::new(&here);
            let directions = grid.directions();
            let truth = input.truth.yxy_map(&here, &directions)?;
            let found = fit.model.yxy_map(&here, &directions).ok();
            let images = triple(&here, &grid, &truth, found.as_deref())?;
            let median = white_luminance(&truth).unwrap_or(f64::NAN)
                / sky_science::metrics::WHITE_PER_MEDIAN_LUMINANCE;
            body.push_str(&format!(
                "<figure class=\"triple\"><figcaption>sun {}°, median {} cd/m²</figcaption>",
                short(sun),
                two_digits(median)
            ));
            for (what, image) in ["truth", "fit", "difference"].iter().zip(&images) {
                if let Some(image) = image {
                    body.push_str(&format!(
                        "<img width=\"168\" height=\"168\" src=\"{image}\" alt=\"{what}, {} km, sun {}°\">",
                        short(km),
                        short(sun)
                    ));
                }
            }
            if found.is_none() {
                body.push_str("<p class=\"soft\">outside the fit's domain</p>");
            }
            body.push_str("</figure>\n");
        }
    }
    body.push_str("</div>\n");
    Ok(Section {
        id: "pictures",
        title: "Pictures: truth, fit, difference",
        body,
    })
}

/// Two significant digits, thousands in groups.
fn two_digits(value: f64) -> String {
    if !(value.is_finite() && value > 0.0) {
        return value.to_string();
    }
    let unit = 10.0_f64.powf(value.log10().floor() - 1.0);
    let rounded = (value / unit).round() * unit;
    if rounded < 10_000.0 {
        short(rounded)
    } else {
        let whole = format!("{rounded:.0}");
        let (head, tail) = whole.split_at(whole.len() - 3);
        format!("{head} {tail}")
    }
}

/// Sun zenith angles of a path, 0–96°, three quarters of them beyond 80°.
fn path_suns(count: u8) -> Vec<f64> {
    let last = f64::from(count.max(2) - 1);
    (0..count.max(2))
        .map(|i| {
            let s = f64::from(i) / last;
            if s < 0.25 {
                80.0 * s / 0.25
            } else {
                80.0 + 16.0 * (s - 0.25) / 0.75
            }
        })
        .collect()
}

/// Where the color is looked at: name, azimuth, and whether at the zenith or 1° above the horizon.
const VIEWS: [(&str, f64, bool); 3] = [
    ("zenith", 0.0, true),
    ("horizon below the sun", 0.0, false),
    ("horizon opposite", 180.0, false),
];

/// Sun zenith angles that are written beside a path \[deg\].
const MARKED_SUNS_DEG: [f64; 4] = [0.0, 80.0, 90.0, 96.0];

fn view_directions(here: &Conditions) -> Vec<SkyDirection> {
    let low = horizon_zenith(here.observer_altitude).degrees() - 1.0;
    VIEWS
        .iter()
        .map(|&(_, azimuth, zenith)| {
            SkyDirection::from_degrees(if zenith { 0.0 } else { low }, azimuth)
        })
        .collect()
}

/// One color a view for each sun, where the model answers.
fn path(model: &dyn SkyModel, km: f64, turbidity: f64, suns: &[f64]) -> Vec<(f64, Vec<Yxy>)> {
    suns.iter()
        .filter_map(|&sun| {
            let here = conditions(km, turbidity, sun);
            Some((sun, model.yxy_map(&here, &view_directions(&here)).ok()?))
        })
        .collect()
}

pub(super) fn chromaticity_paths(input: &ReportInput<'_>, csv: &mut LongTable) -> Result<Section> {
    let turbidity = input.settings.scene_turbidity;
    let fit = &input.fits[0];
    let suns = path_suns(input.settings.path_suns);
    let mut body = format!(
        "<p>Chromaticity (CIE 1931 2°) of the zenith and of the horizon, 1° above the geometric one, \
         while the sun goes from the zenith to 96°, at turbidity {}. Solid: truth; dashed: {}. D65 is \
         the white of the sRGB display; the outer curve is the spectral locus. The sun's disc is not \
         part of the sky, but its aureole is: below the setting sun it colors the horizon.</p>\n\
         <div class=\"grid\">",
        short(turbidity),
        escape(&fit.name)
    );
    let locus: Vec<[f64; 2]> = spectral_locus().to_vec();
    for km in [0.0, 12.0] {
        let truth = path(input.truth, km, turbidity, &suns);
        let found = path(fit.model, km, turbidity, &suns);
        let mut series = vec![Series::new("", 0, locus.clone()).in_ink()];
        let mut notes = Vec::new();
        for (view, (name, _, _)) in VIEWS.iter().enumerate() {
            for (channel, colors) in [("truth", &truth), (fit.name.as_str(), &found)] {
                for (sun, map) in colors {
                    let here = conditions(km, turbidity, *sun);
                    for (key, value) in [
                        ("Y [cd/m2]", map[view].luminance_cd_m2),
                        ("x", map[view].x),
                        ("y", map[view].y),
                    ] {
                        let key = format!("{name}: {key}");
                        csv.figure("chromaticity", &key, Some(&here), channel, value);
                    }
                }
            }
            let points = |colors: &[(f64, Vec<Yxy>)]| -> Vec<[f64; 2]> {
                colors
                    .iter()
                    .map(|(_, map)| [map[view].x, map[view].y])
                    .collect()
            };
            series.push(Series::new(*name, view, points(&truth)));
            series.push(Series::new("", view, points(&found)).stroked(Stroke::Dashed));
            let marked = MARKED_SUNS_DEG.map(|sun| {
                let here = conditions(km, turbidity, sun);
                let map = input.truth.yxy_map(&here, &view_directions(&here))?;
                Ok((sun, [map[view].x, map[view].y]))
            });
            let marked: Vec<(f64, [f64; 2])> = marked.into_iter().collect::<Result<_>>()?;
            let dots = marked.iter().map(|(_, at)| *at).collect();
            series.push(Series::new("", view, dots).stroked(Stroke::Dots));
            // Opposite the sun the path turns back on itself: names would cover each other.
            let named = if view == 2 { &[][..] } else { &marked[..] };
            notes.extend(named.iter().map(|(sun, [x, y])| Note {
                text: format!("{}°", short(*sun)),
                at: [x + 0.003, y - 0.002],
            }));
        }
        series.push(
            Series::new("D65", 0, vec![[0.3127, 0.3290]])
                .in_ink()
                .stroked(Stroke::Dots),
        );
        let shown = || series.iter().skip(1).flat_map(|s| &s.points);
        let extent = |axis: usize| shown().map(move |p| p[axis]).collect::<Vec<_>>();
        let chart = Chart {
            title: format!("{} km", short(km)),
            x: Scale::linear("x", extent(0)),
            y: Scale::linear("y", extent(1)),
            series: series.clone(),
            notes,
            size: [560, 400],
        };
        body.push_str(&chart.html()?);
        if km < 1.0 {
            let names = [450_u16, 480, 500, 520, 550, 580, 600, 700].map(|nm| Note {
                text: nm.to_string(),
                at: {
                    let [x, y] = locus[usize::from(nm - 360)];
                    [x + 0.012, y + 0.012]
                },
            });
            let mut closed = locus.clone();
            closed.push(locus[0]);
            series[0] = Series::new("", 0, closed).in_ink();
            for series in &mut series {
                series.name.clear();
            }
            body.push_str(
                &Chart {
                    title: "The same within all colors; wavelengths in nm".to_owned(),
                    x: Scale::linear_from("x", [0.0, 0.8]),
                    y: Scale::linear_from("y", [0.0, 0.9]),
                    series: series
                        .into_iter()
                        .filter(|s| s.stroke != Stroke::Dots)
                        .collect(),
                    notes: names.to_vec(),
                    size: [360, 400],
                }
                .html()?,
            );
        }
    }
    body.push_str("</div>\n");
    Ok(Section {
        id: "chromaticity",
        title: "Chromaticity as the sun sets",
        body,
    })
}
