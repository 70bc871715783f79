//! Charts as inline SVG, drawn by plotters.
//!
//! Ink is `currentColor`, so a chart follows the page's light or dark scheme. Legends are HTML, beside
//! the chart. Coordinates are drawn four times as large as shown, because plotters rounds to whole
//! pixels.

use core::ops::Range;

use anyhow::{Result, anyhow};
use plotters::coord::ranged1d::{
    KeyPointHint, NoDefaultFormatting, Ranged, ReversibleRanged, ValueFormatter,
};
use plotters::prelude::*;

use super::page::escape;

/// Drawn units per shown pixel.
const ZOOM: u32 = 4;

/// Stands for the ink while drawing; replaced by `currentColor`.
const INK: RGBColor = RGBColor(1, 2, 3);
const INK_SVG: &str = "#010203";

/// Colors of series, legible on white and on black (after Okabe & Ito 2008).
pub(crate) const SERIES_COLORS: [RGBColor; 8] = [
    RGBColor(30, 120, 200),
    RGBColor(225, 115, 20),
    RGBColor(20, 155, 110),
    RGBColor(200, 80, 150),
    RGBColor(145, 105, 205),
    RGBColor(190, 150, 20),
    RGBColor(90, 170, 220),
    RGBColor(150, 95, 60),
];

/// An axis: its caption with unit, range and ticks.
#[derive(Clone, Debug)]
pub(crate) struct Scale {
    caption: String,
    range: [f64; 2],
    logarithmic: bool,
    ticks: Vec<f64>,
    labels: Option<Vec<String>>,
}

impl Scale {
    /// A linear axis over the values (finite ones), widened to whole ticks.
    pub(crate) fn linear(caption: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let [low, high] = extent(values);
        let step = tick_step(high - low);
        let range = [(low / step).floor() * step, (high / step).ceil() * step];
        Self::linear_from(caption, range)
    }

    /// A linear axis over a fixed range.
    pub(crate) fn linear_from(caption: &str, range: [f64; 2]) -> Self {
        let step = tick_step(range[1] - range[0]);
        let mut ticks = Vec::new();
        let mut n = (range[0] / step - 1e-9).ceil();
        while n * step <= range[1] + 1e-9 * step {
            ticks.push(n * step);
            n += 1.0;
        }
        Self {
            caption: caption.to_owned(),
            range,
            logarithmic: false,
            ticks,
            labels: None,
        }
    }

    /// A logarithmic axis over the positive values, at most `decades` down from the largest.
    pub(crate) fn logarithmic(
        caption: &str,
        values: impl IntoIterator<Item = f64>,
        decades: f64,
    ) -> Self {
        let [low, high] = extent(values.into_iter().filter(|v| *v > 0.0));
        let high = high.max(f64::MIN_POSITIVE);
        let low = low.max(high * 10.0_f64.powf(-decades));
        // Widened to 1, 2 or 5 of the decade.
        let niced = |v: f64, up: bool| {
            let decade = 10.0_f64.powf(v.log10().floor());
            let lead = v / decade;
            let mut steps = [1.0, 2.0, 5.0, 10.0];
            if !up {
                steps.reverse();
            }
            let fits = |s: &&f64| {
                if up {
                    **s >= lead - 1e-9
                } else {
                    **s <= lead + 1e-9
                }
            };
            decade * steps.iter().find(fits).copied().unwrap_or(1.0)
        };
        let mut range = [niced(low, false), niced(high, true)];
        if range[1] < 1.5 * range[0] {
            range[1] = 2.0 * range[0];
        }
        let span = (range[1] / range[0]).log10();
        let leads: &[f64] = if span > 4.0 {
            &[1.0]
        } else if span > 1.5 {
            &[1.0, 3.0]
        } else {
            &[1.0, 2.0, 5.0]
        };
        let stride = if span > 9.0 { 2.0 } else { 1.0 };
        let mut ticks = Vec::new();
        let mut decade = range[0].log10().floor();
        while decade <= range[1].log10() {
            for lead in leads {
                let tick = lead * 10.0_f64.powf(decade);
                if tick >= range[0] * 0.999 && tick <= range[1] * 1.001 {
                    ticks.push(tick);
                }
            }
            decade += stride;
        }
        Self {
            caption: caption.to_owned(),
            range,
            logarithmic: true,
            ticks,
            labels: None,
        }
    }

    /// A linear axis from the first to the last tick, each with its own label.
    pub(crate) fn labeled(caption: &str, ticks: &[(f64, String)]) -> Self {
        let first = ticks.first().map_or(0.0, |t| t.0);
        let last = ticks.last().map_or(1.0, |t| t.0);
        Self {
            caption: caption.to_owned(),
            range: [first, last],
            logarithmic: false,
            ticks: ticks.iter().map(|t| t.0).collect(),
            labels: Some(ticks.iter().map(|t| t.1.clone()).collect()),
        }
    }

    /// Where the axis begins.
    pub(crate) const fn low(&self) -> f64 {
        self.range[0]
    }

    /// Places 0, 1, 2 … with a label each, as the rows or columns of a table have.
    fn places(caption: &str, labels: &[String], room: usize) -> Self {
        let stride = labels.len().div_ceil(room.max(1)).max(1);
        let shown: Vec<usize> = (0..labels.len()).step_by(stride).collect();
        Self {
            caption: caption.to_owned(),
            range: [-0.5, index(labels.len()) - 0.5],
            logarithmic: false,
            ticks: shown.iter().map(|&i| index(i)).collect(),
            labels: Some(shown.iter().map(|&i| labels[i].clone()).collect()),
        }
    }

    /// Every n-th tick, so that there are at most `room`.
    fn thinned(mut self, room: u32) -> Self {
        let room = usize::try_from(room.max(2)).unwrap_or(2);
        let stride = self.ticks.len().div_ceil(room).max(1);
        // Round numbers stay: of 0.1, 0.2 … those that a coarser step would have, too.
        let first = if self.labels.is_some() || self.logarithmic || self.ticks.len() < 2 {
            0
        } else {
            let step = (self.ticks[1] - self.ticks[0]) * index(stride);
            let on_step = |t: &f64| (t / step - (t / step).round()).abs() < 1e-6;
            self.ticks.iter().position(on_step).unwrap_or(0)
        };
        if let Some(labels) = &mut self.labels {
            *labels = labels.iter().step_by(stride).cloned().collect();
        }
        self.ticks = self
            .ticks
            .iter()
            .skip(first)
            .step_by(stride)
            .copied()
            .collect();
        self
    }

    fn place(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        if self.logarithmic {
            let value = value.max(low * 1e-3);
            (value / low).ln() / (high / low).ln()
        } else {
            (value - low) / (high - low)
        }
    }
}

fn extent(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let finite = values.into_iter().filter(|v| v.is_finite());
    let [low, high] = finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
        [low.min(v), high.max(v)]
    });
    if low > high {
        return [0.0, 1.0];
    }
    if high - low < 1e-12 * high.abs().max(1e-12) {
        return [
            low - 0.5 * low.abs().max(1e-3),
            high + 0.5 * high.abs().max(1e-3),
        ];
    }
    [low, high]
}

/// 1, 2 or 5 times a power of ten, for five to ten ticks.
fn tick_step(span: f64) -> f64 {
    let rough = span.max(1e-300) / 7.0;
    let decade = 10.0_f64.powf(rough.log10().floor());
    let lead = rough / decade;
    decade
        * if lead < 1.5 {
            1.0
        } else if lead < 3.5 {
            2.0
        } else if lead < 7.5 {
            5.0
        } else {
            10.0
        }
}

fn index(i: usize) -> f64 {
    f64::from(u32::try_from(i).unwrap_or(u32::MAX))
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "a rounded place on a canvas of some thousand units; far values are cut to it"
)]
fn canvas(value: f64) -> i32 {
    value.round().clamp(-1e6, 1e6) as i32
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let (start, end) = (f64::from(limit.0), f64::from(limit.1));
        canvas(start + self.place(*value).clamp(-0.2, 1.2) * (end - start))
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range[0]..self.range[1]
    }
}

impl ReversibleRanged for Scale {
    fn unmap(&self, _input: i32, _limit: (i32, i32)) -> Option<f64> {
        None
    }
}

impl ValueFormatter<f64> for Scale {
    fn format_ext(&self, value: &f64) -> String {
        if let Some(labels) = &self.labels {
            let at = self.ticks.iter().position(|t| (t - value).abs() < 1e-6);
            return at.map_or_else(String::new, |i| labels[i].clone());
        }
        short(*value)
    }
}

/// A number in few characters: plain between 0.001 and 100 000, else with a power of ten.
pub(crate) fn short(value: f64) -> String {
    let size = value.abs();
    if size < 1e-12 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let text = if (1e-3..1e5).contains(&size) {
        let decimals = if size < 0.01 {
            5
        } else if size < 1.0 {
            4
        } else if size < 100.0 {
            3
        } else {
            1
        };
        format!("{value:.decimals$}")
    } else {
        return format!("{value:.1e}").replace(".0e", "e");
    };
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stroke {
    /// A line.
    Solid,
    /// A dashed line.
    Dashed,
    /// Dots only.
    Dots,
}

/// A line of a chart.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    /// For the legend; empty for none.
    pub(crate) name: String,
    /// x, y.
    pub(crate) points: Vec<[f64; 2]>,
    /// Color; `None` for ink.
    pub(crate) color: Option<RGBColor>,
    /// Line or dots.
    pub(crate) stroke: Stroke,
}

impl Series {
    pub(crate) fn new(name: impl Into<String>, color: usize, points: Vec<[f64; 2]>) -> Self {
        Self {
            name: name.into(),
            points,
            color: Some(SERIES_COLORS[color % SERIES_COLORS.len()]),
            stroke: Stroke::Solid,
        }
    }

    pub(crate) fn stroked(mut self, stroke: Stroke) -> Self {
        self.stroke = stroke;
        self
    }

    pub(crate) fn in_ink(mut self) -> Self {
        self.color = None;
        self
    }
}

/// A word at a place of a chart.
#[derive(Clone, Debug)]
pub(crate) struct Note {
    /// The word.
    pub(crate) text: String,
    /// x, y.
    pub(crate) at: [f64; 2],
}

/// A chart of lines.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    /// Heading above it.
    pub(crate) title: String,
    /// Horizontal axis.
    pub(crate) x: Scale,
    /// Vertical axis.
    pub(crate) y: Scale,
    /// Lines.
    pub(crate) series: Vec<Series>,
    /// Words.
    pub(crate) notes: Vec<Note>,
    /// Shown size \[px\].
    pub(crate) size: [u32; 2],
}

fn drawing_error(error: impl std::fmt::Display) -> anyhow::Error {
    anyhow!("report: a chart could not be drawn: {error}")
}

const ZOOMED_PX: f64 = 4.0;

/// Around the plot \[px\].
const MARGIN: u32 = 6;
const RIGHT_MARGIN: u32 = 14;
const X_LABELS: u32 = 34;
const Y_LABELS: u32 = 52;
/// Size of the words in a chart \[px\].
const NOTE_PX: f64 = 9.5;

#[expect(clippy::cast_possible_truncation, reason = "a few thousand at most")]
fn zoomed(px: f64) -> i32 {
    (px * ZOOMED_PX).round() as i32
}

fn font(px: f64) -> TextStyle<'static> {
    // plotters writes its size divided by 1.24.
    ("sans-serif", px * 1.24 * ZOOMED_PX)
        .into_font()
        .color(&INK)
}

fn cut_head(svg: &str, size: [u32; 2], title: &str) -> String {
    let body = svg.split_once('>').map_or("", |(_, body)| body);
    let body = body.replace(INK_SVG, "currentColor");
    let (width, height) = (size[0] * ZOOM, size[1] * ZOOM);
    // Without a name space: inline in HTML an svg needs none, and the page then names no address.
    format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\" \
         style=\"width:{}px\">{body}",
        escape(title),
        size[0]
    )
}

impl Chart {
    /// The chart with its heading and legend.
    pub(crate) fn html(&self) -> Result<String> {
        let mut svg = String::new();
        self.draw(&mut svg)?;
        Ok(format!(
            "<figure class=\"chart\"><figcaption>{}</figcaption>{}{}</figure>\n",
            escape(&self.title),
            cut_head(&svg, self.size, &self.title),
            self.legend()
        ))
    }

    fn legend(&self) -> String {
        let mut out = String::new();
        for series in self.series.iter().filter(|s| !s.name.is_empty()) {
            let color = series.color.map_or_else(
                || "currentColor".to_owned(),
                |RGBColor(r, g, b)| format!("rgb({r},{g},{b})"),
            );
            let class = match series.stroke {
                Stroke::Solid => "key",
                Stroke::Dashed => "key dashed",
                Stroke::Dots => "key dots",
            };
            out.push_str(&format!(
                "<span><i class=\"{class}\" style=\"border-color:{color}\"></i>{}</span>",
                escape(&series.name)
            ));
        }
        if out.is_empty() {
            out
        } else {
            format!("<div class=\"legend\">{out}</div>")
        }
    }

    /// How far each word stands from its place \[px of the zoomed drawing\]: as near as goes without
    /// lying on another word or beyond the right edge; the first words choose first.
    fn note_offsets(&self) -> Vec<(i32, i32)> {
        const LINE_PX: f64 = 1.15 * NOTE_PX;
        const LETTER_PX: f64 = 0.53 * NOTE_PX;
        let [width, height] = [
            f64::from(self.size[0]) - f64::from(MARGIN + RIGHT_MARGIN + Y_LABELS),
            f64::from(self.size[1]) - f64::from(2 * MARGIN + X_LABELS),
        ];
        let mut taken: Vec<[f64; 4]> = Vec::new();
        let mut offsets = Vec::new();
        for note in &self.notes {
            let at = [
                self.x.place(note.at[0]) * width,
                (1.0 - self.y.place(note.at[1])) * height,
            ];
            let length = LETTER_PX * index(note.text.chars().count());
            let shift = (width + f64::from(RIGHT_MARGIN) - at[0] - length).min(0.0);
            let free = |down: f64| {
                let [left, top] = [at[0] + shift, at[1] + down];
                let box_ = [left, top, left + length, top + LINE_PX];
                let clear = taken.iter().all(|other| {
                    box_[0] >= other[2]
                        || other[0] >= box_[2]
                        || box_[1] >= other[3]
                        || other[1] >= box_[3]
                });
                (clear && top >= -LINE_PX && box_[3] <= height + LINE_PX).then_some(box_)
            };
            let mut steps = (0..8).flat_map(|n| {
                let step = f64::from(n) * 0.5 * LINE_PX;
                [step, -step - LINE_PX]
            });
            let (down, box_) = steps
                .find_map(|down| Some((down, free(down)?)))
                .unwrap_or((0.0, [0.0; 4]));
            taken.push(box_);
            offsets.push((zoomed(shift), zoomed(down)));
        }
        offsets
    }

    fn draw(&self, svg: &mut String) -> Result<()> {
        let size = (self.size[0] * ZOOM, self.size[1] * ZOOM);
        let root = SVGBackend::with_string(svg, size).into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .margin(MARGIN * ZOOM)
            .margin_right(RIGHT_MARGIN * ZOOM)
            .x_label_area_size(X_LABELS * ZOOM)
            .y_label_area_size(Y_LABELS * ZOOM)
            .build_cartesian_2d(
                self.x.clone().thinned(self.size[0] / 46),
                self.y.clone().thinned(self.size[1] / 28),
            )
            .map_err(drawing_error)?;
        chart
            .configure_mesh()
            .x_desc(self.x.caption.as_str())
            .y_desc(self.y.caption.as_str())
            .axis_style(ShapeStyle {
                color: INK.mix(0.6),
                filled: false,
                stroke_width: ZOOM,
            })
            .bold_line_style(ShapeStyle {
                color: INK.mix(0.16),
                filled: false,
                stroke_width: ZOOM,
            })
            .light_line_style(TRANSPARENT)
            .label_style(font(10.5))
            .axis_desc_style(font(11.0))
            .draw()
            .map_err(drawing_error)?;
        let (area_x, area_y) = (self.x.range, self.y.range);
        for series in &self.series {
            let color = series.color.unwrap_or(INK);
            let style = ShapeStyle {
                color: color.to_rgba(),
                filled: series.stroke == Stroke::Dots,
                stroke_width: ZOOM * 7 / 4,
            };
            if series.stroke == Stroke::Dots {
                let inside = |p: &&[f64; 2]| {
                    (area_x[0]..=area_x[1]).contains(&p[0])
                        && (area_y[0]..=area_y[1]).contains(&p[1])
                };
                chart
                    .draw_series(
                        series
                            .points
                            .iter()
                            .filter(inside)
                            .map(|p| Circle::new((p[0], p[1]), 2 * ZOOM, style)),
                    )
                    .map_err(drawing_error)?;
                continue;
            }
            for piece in clipped(&series.points, &self.x, &self.y) {
                let points = piece.into_iter().map(|[x, y]| (x, y));
                if series.stroke == Stroke::Solid {
                    chart
                        .draw_series(LineSeries::new(points, style))
                        .map_err(drawing_error)?;
                } else {
                    let points: Vec<(f64, f64)> = points.collect();
                    chart
                        .draw_series(DashedLineSeries::new(points, 5 * ZOOM, 4 * ZOOM, style))
                        .map_err(drawing_error)?;
                }
            }
        }
        chart
            .draw_series(
                self.notes
                    .iter()
                    .zip(self.note_offsets())
                    .map(|(note, offset)| {
                        EmptyElement::at((note.at[0], note.at[1]))
                            + Text::new(note.text.clone(), offset, font(NOTE_PX))
                    }),
            )
            .map_err(drawing_error)?;
        root.present().map_err(drawing_error)?;
        drop(chart);
        drop(root);
        Ok(())
    }
}

/// A polyline cut at the edges of the plot (in the axes' own, possibly logarithmic, places) and at
/// values that are not finite.
fn clipped(points: &[[f64; 2]], x: &Scale, y: &Scale) -> Vec<Vec<[f64; 2]>> {
    let place = |p: &[f64; 2]| [x.place(p[0]), y.place(p[1])];
    let value = |scale: &Scale, share: f64| {
        let [low, high] = scale.range;
        if scale.logarithmic {
            low * (share * (high / low).ln()).exp()
        } else {
            low + share * (high - low)
        }
    };
    let mut pieces: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut open = false;
    for pair in points.windows(2) {
        let (a, b) = (place(&pair[0]), place(&pair[1]));
        if !a.iter().chain(&b).all(|v| v.is_finite()) {
            open = false;
            continue;
        }
        // Liang and Barsky's clipping to the unit square.
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let run = b[axis] - a[axis];
            for (speed, room) in [(-run, a[axis]), (run, 1.0 - a[axis])] {
                if speed.abs() < 1e-15 {
                    if room < 0.0 {
                        from = 2.0;
                    }
                } else if speed < 0.0 {
                    from = from.max(room / speed);
                } else {
                    to = to.min(room / speed);
                }
            }
        }
        if from > to {
            open = false;
            continue;
        }
        let at = |t: f64| {
            [
                value(x, a[0] + t * (b[0] - a[0])),
                value(y, a[1] + t * (b[1] - a[1])),
            ]
        };
        if !open || from > 0.0 {
            pieces.push(vec![at(from)]);
        }
        if let Some(piece) = pieces.last_mut() {
            piece.push(at(to));
        }
        open = to >= 1.0;
    }
    pieces
}

/// A table of values as colors.
#[derive(Clone, Debug)]
pub(crate) struct HeatMap {
    /// Heading above it.
    pub(crate) title: String,
    /// Caption and labels of the columns.
    pub(crate) x: (String, Vec<String>),
    /// Caption and labels of the rows, from below.
    pub(crate) y: (String, Vec<String>),
    /// Row by row from below; NaN for no value.
    pub(crate) values: Vec<f64>,
    /// Value of the last color.
    pub(crate) full_scale: f64,
    /// Shown size \[px\].
    pub(crate) size: [u32; 2],
}

impl HeatMap {
    /// The map with its heading; [`color_bar`] belongs to it.
    pub(crate) fn html(&self) -> Result<String> {
        self.html_colored(|i| {
            let value = self.values[i];
            (!value.is_nan()).then(|| heat_color(value / self.full_scale))
        })
    }

    /// The map in other colors, by the index of a value; `None` leaves a cell empty.
    pub(crate) fn html_colored(&self, color: impl Fn(usize) -> Option<[u8; 3]>) -> Result<String> {
        let mut svg = String::new();
        self.draw(&mut svg, color)?;
        Ok(format!(
            "<figure class=\"chart\"><figcaption>{}</figcaption>{}</figure>\n",
            escape(&self.title),
            cut_head(&svg, self.size, &self.title)
        ))
    }

    fn draw(&self, svg: &mut String, color: impl Fn(usize) -> Option<[u8; 3]>) -> Result<()> {
        let size = (self.size[0] * ZOOM, self.size[1] * ZOOM);
        let columns = self.x.1.len();
        let room_x = usize::try_from(self.size[0].saturating_sub(70) / 26).unwrap_or(1);
        let room_y = usize::try_from(self.size[1].saturating_sub(50) / 12).unwrap_or(1);
        let root = SVGBackend::with_string(svg, size).into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .margin(6 * ZOOM)
            .x_label_area_size(34 * ZOOM)
            .y_label_area_size(46 * ZOOM)
            .build_cartesian_2d(
                Scale::places(&self.x.0, &self.x.1, room_x),
                Scale::places(&self.y.0, &self.y.1, room_y),
            )
            .map_err(drawing_error)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc(self.x.0.as_str())
            .y_desc(self.y.0.as_str())
            .axis_style(ShapeStyle {
                color: INK.mix(0.6),
                filled: false,
                stroke_width: ZOOM,
            })
            .label_style(font(9.5))
            .axis_desc_style(font(11.0))
            .draw()
            .map_err(drawing_error)?;
        let cells = (0..self.values.len()).filter_map(|i| color(i).map(|c| (i, c)));
        chart
            .draw_series(cells.map(|(i, [r, g, b])| {
                let (column, row) = (index(i % columns), index(i / columns));
                Rectangle::new(
                    [(column - 0.5, row - 0.5), (column + 0.5, row + 0.5)],
                    RGBColor(r, g, b).filled(),
                )
            }))
            .map_err(drawing_error)?;
        root.present().map_err(drawing_error)?;
        drop(chart);
        drop(root);
        Ok(())
    }
}

/// Nine colors of equal steps in lightness, dark for small values (after matplotlib's inferno, CC0).
const HEAT: [[u8; 3]; 9] = [
    [13, 8, 40],
    [48, 18, 95],
    [96, 24, 110],
    [142, 37, 104],
    [187, 55, 84],
    [221, 81, 58],
    [243, 121, 25],
    [252, 173, 18],
    [246, 225, 120],
];

/// Color of a share of the full scale; beyond it, near white.
pub(crate) fn heat_color(share: f64) -> [u8; 3] {
    if !share.is_finite() || share > 1.0 {
        return [252, 255, 220];
    }
    let place = share.max(0.0) * 8.0;
    let (mut low, mut t) = (0_usize, place);
    while t >= 1.0 && low < 7 {
        low += 1;
        t -= 1.0;
    }
    core::array::from_fn(|c| {
        let (a, b) = (f64::from(HEAT[low][c]), f64::from(HEAT[low + 1][c]));
        super::picture::byte((a + t * (b - a)) / 255.0)
    })
}

/// The scale of [`heat_color`], from 0 to the full scale.
pub(crate) fn color_bar(full_scale: f64, unit: &str) -> String {
    let stops: Vec<String> = HEAT
        .iter()
        .map(|[r, g, b]| format!("rgb({r},{g},{b})"))
        .collect();
    format!(
        "<div class=\"bar\"><span>0</span><i style=\"background:linear-gradient(90deg,{})\"></i>\
         <span>{} {}; pale: more</span></div>\n",
        stops.join(","),
        short(full_scale),
        escape(unit)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let scale = Scale::linear("x", [0.3, 9.7]);
        assert!(scale.range[0].abs() < 1e-12 && (scale.range[1] - 10.0).abs() < 1e-12);
        assert_eq!(scale.ticks.len(), 11);
        let log = Scale::logarithmic("y", [0.02, 700.0], 9.0);
        assert!((log.range[0] - 0.02).abs() < 1e-12 && (log.range[1] - 1000.0).abs() < 1e-9);
        assert!(log.ticks.iter().all(|t| (0.0199..=1001.0).contains(t)));
    }

    #[test]
    fn words_do_not_lie_on_each_other() {
        let note = |x: f64, y: f64| Note {
            text: "a word".to_owned(),
            at: [x, y],
        };
        let chart = Chart {
            title: String::new(),
            x: Scale::linear("x", [0.0, 10.0]),
            y: Scale::linear("y", [0.0, 10.0]),
            series: Vec::new(),
            notes: vec![
                note(5.0, 5.0),
                note(5.1, 5.0),
                note(9.9, 5.0),
                note(1.0, 9.0),
            ],
            size: [560, 360],
        };
        let offsets = chart.note_offsets();
        assert_eq!(offsets[0], (0, 0));
        assert!(offsets[1].1.abs() > 20, "the second moves: {offsets:?}");
        assert!(offsets[2].0 < 0, "the third ends at the edge: {offsets:?}");
        assert_eq!(offsets[3], (0, 0));
    }

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (10.0, "10"),
            (0.25, "0.25"),
            (100_000.0, "1e5"),
            (-3.5, "-3.5"),
            (2.5e-5, "2.5e-5"),
            (400.0, "400"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn lines_end_at_the_edge_of_the_plot() {
        let unit = Scale::linear_from("", [0.0, 1.0]);
        let pieces = clipped(
            &[
                [0.5, 0.5],
                [1.5, 0.5],
                [0.5, 0.7],
                [f64::NAN, 0.2],
                [0.1, 0.1],
                [0.2, 0.2],
            ],
            &unit,
            &unit,
        );
        assert_eq!(pieces.len(), 3);
        assert!((pieces[0][1][0] - 1.0).abs() < 1e-12);
        assert!((pieces[1][0][0] - 1.0).abs() < 1e-12);
        assert_eq!(pieces[2].len(), 2);
    }
}
