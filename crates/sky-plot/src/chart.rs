//! Charts as inline SVG, drawn by plotters.
//!
//! Ink is `currentColor`, so a chart follows the page's light or dark scheme. Legends are HTML, beside
//! the chart. Coordinates are drawn four times as large as shown, because plotters rounds to whole
//! pixels.

use plotters::prelude::*;

use crate::page::escape;
use crate::scale::{Scale, index};
use crate::svg::{DrawError, INK, ZOOM, cut_head, drawing_error, font, zoomed};

/// Colors of series, legible on white and on black (after Okabe & Ito 2008).
pub const SERIES_COLORS: [RGBColor; 8] = [
    RGBColor(30, 120, 200),
    RGBColor(225, 115, 20),
    RGBColor(20, 155, 110),
    RGBColor(200, 80, 150),
    RGBColor(145, 105, 205),
    RGBColor(190, 150, 20),
    RGBColor(90, 170, 220),
    RGBColor(150, 95, 60),
];

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// A line.
    Solid,
    /// A dashed line.
    Dashed,
    /// Dots only.
    Dots,
}

/// A line of a chart.
#[derive(Clone, Debug)]
pub struct Series {
    /// For the legend; empty for none.
    pub name: String,
    /// x, y.
    pub points: Vec<[f64; 2]>,
    /// Color; `None` for ink.
    pub color: Option<RGBColor>,
    /// Line or dots.
    pub stroke: Stroke,
}

impl Series {
    /// A line in one of the [`SERIES_COLORS`].
    #[must_use]
    pub fn new(name: impl Into<String>, color: usize, points: Vec<[f64; 2]>) -> Self {
        Self {
            name: name.into(),
            points,
            color: Some(SERIES_COLORS[color % SERIES_COLORS.len()]),
            stroke: Stroke::Solid,
        }
    }

    /// The same with another stroke.
    #[must_use]
    pub fn stroked(mut self, stroke: Stroke) -> Self {
        self.stroke = stroke;
        self
    }

    /// The same in ink.
    #[must_use]
    pub fn in_ink(mut self) -> Self {
        self.color = None;
        self
    }
}

/// A word at a place of a chart.
#[derive(Clone, Debug)]
pub struct Note {
    /// The word.
    pub text: String,
    /// x, y.
    pub at: [f64; 2],
}

/// A chart of lines.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Heading above it.
    pub title: String,
    /// Horizontal axis.
    pub x: Scale,
    /// Vertical axis.
    pub y: Scale,
    /// Lines.
    pub series: Vec<Series>,
    /// Words.
    pub notes: Vec<Note>,
    /// Shown size \[px\].
    pub size: [u32; 2],
}

/// Around the plot \[px\].
const MARGIN: u32 = 6;
const RIGHT_MARGIN: u32 = 14;
const X_LABELS: u32 = 34;
const Y_LABELS: u32 = 52;
/// Size of the words in a chart \[px\].
const NOTE_PX: f64 = 9.5;

impl Chart {
    /// The chart with its heading and legend.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn html(&self) -> Result<String, DrawError> {
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

    fn draw(&self, svg: &mut String) -> Result<(), DrawError> {
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

#[cfg(test)]
mod tests {
    use super::*;

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
