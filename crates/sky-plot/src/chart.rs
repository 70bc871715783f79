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
const NOTE_PX: f64 = 11.0;
/// A line of words, and a letter of the widest common sans-serif face.
const LINE_PX: f64 = 1.2 * NOTE_PX;
const LETTER_PX: f64 = 0.62 * NOTE_PX;
/// Radius of a dot with some air around it.
const DOT_PX: f64 = 4.0;
/// From a dot to its word, and to a word that stands so far that a line has to lead to it.
const NEAR_PX: f64 = 6.0;
const LED_PX: f64 = 12.0;
/// Lines of more points are not kept clear of words.
const MOST_CLEARED: usize = 16;

/// A rectangle: left, top, right, bottom \[px\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Box([f64; 4]);

impl Box {
    pub(crate) fn around([x, y]: [f64; 2], [width, height]: [f64; 2]) -> Self {
        Self([
            x - 0.5 * width,
            y - 0.5 * height,
            x + 0.5 * width,
            y + 0.5 * height,
        ])
    }

    pub(crate) fn lies_on(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.0[axis] < other.0[axis + 2] && other.0[axis] < self.0[axis + 2])
    }

    fn is_within(&self, [width, height]: [f64; 2]) -> bool {
        self.0[0] >= 0.0 && self.0[1] >= 0.0 && self.0[2] <= width && self.0[3] <= height
    }
}

/// Small squares along a line, its ends left out: what must not be written over.
fn along(from: [f64; 2], to: [f64; 2]) -> impl Iterator<Item = Box> {
    const STEPS: u8 = 60;
    (1..STEPS).map(move |i| {
        let share = f64::from(i) / f64::from(STEPS);
        let place = core::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis]));
        Box::around(place, [1.0; 2])
    })
}

/// A word that has its place.
#[derive(Clone, Copy, Debug)]
struct Placed {
    /// What it is said of.
    at: [f64; 2],
    word: Box,
    /// Whether the word is too far to be seen as that of the place.
    is_led: bool,
}

impl Placed {
    /// The word's upper left corner from the place \[px of the zoomed drawing\].
    fn corner(&self) -> (i32, i32) {
        let [left, top, ..] = self.word.0;
        (zoomed(left - self.at[0]), zoomed(top - self.at[1]))
    }

    /// Where the word is nearest to the place.
    fn nearest(&self) -> [f64; 2] {
        let [left, top, right, bottom] = self.word.0;
        [self.at[0].clamp(left, right), self.at[1].clamp(top, bottom)]
    }

    /// A line from the place to the word; of no length where none is needed.
    fn leader(&self) -> [(i32, i32); 2] {
        if !self.is_led {
            return [(0, 0); 2];
        }
        let nearest = self.nearest();
        [
            (0, 0),
            (
                zoomed(nearest[0] - self.at[0]),
                zoomed(nearest[1] - self.at[1]),
            ),
        ]
    }
}

/// The nearest free place for a word of a size, on rings around its point.
fn placed(at: [f64; 2], size: [f64; 2], plot: [f64; 2], taken: &[Box]) -> Placed {
    // right, left, then above and below, then between
    const TURNS: [f64; 16] = [
        0.0, 8.0, 4.0, 12.0, 1.0, 15.0, 7.0, 9.0, 2.0, 14.0, 6.0, 10.0, 3.0, 13.0, 5.0, 11.0,
    ];
    let ring = |distance: f64| {
        TURNS.map(move |turn| {
            let (sine, cosine) = (turn * core::f64::consts::PI / 8.0).sin_cos();
            let center = [
                at[0] + cosine * (distance + 0.5 * size[0]),
                at[1] + sine * (distance + 0.5 * size[1]),
            ];
            (distance, Box::around(center, size))
        })
    };
    let distances = (0..200_u8).map(|n| NEAR_PX + 3.0 * f64::from(n));
    let free = |word: &Box| word.is_within(plot) && !taken.iter().any(|other| word.lies_on(other));
    let (distance, word) = distances
        .flat_map(ring)
        .find(|(_, word)| free(word))
        // a plot that is full of words
        .unwrap_or_else(|| ring(NEAR_PX)[0]);
    Placed {
        at,
        word,
        is_led: distance > LED_PX,
    }
}

impl Chart {
    /// The chart with its heading and legend.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn html(&self) -> Result<String, DrawError> {
        Ok(format!(
            "<figure class=\"chart\"><figcaption>{}</figcaption>{}{}</figure>\n",
            escape(&self.title),
            self.drawing()?,
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

    /// Where each word stands \[px of the plot, from its upper left corner\]: as near to its place as
    /// goes without lying on another word, on a dot or beyond the plot; the first words choose first.
    fn note_boxes(&self) -> Vec<Placed> {
        let plot = [
            f64::from(self.size[0]) - f64::from(MARGIN + RIGHT_MARGIN + Y_LABELS),
            f64::from(self.size[1]) - f64::from(2 * MARGIN + X_LABELS),
        ];
        let at = |[x, y]: [f64; 2]| [self.x.place(x) * plot[0], (1.0 - self.y.place(y)) * plot[1]];
        let dots = self.series.iter().filter(|s| s.stroke == Stroke::Dots);
        let mut taken: Vec<Box> = dots
            .flat_map(|series| &series.points)
            .chain(self.notes.iter().map(|note| &note.at))
            .map(|point| Box::around(at(*point), [2.0 * DOT_PX; 2]))
            .collect();
        // a front or a path of few points is worth keeping clear, too
        let lines = self.series.iter().filter(|series| {
            series.stroke == Stroke::Dashed && series.points.len() <= MOST_CLEARED
        });
        taken.extend(lines.flat_map(|series| {
            series
                .points
                .windows(2)
                .flat_map(|ends| along(at(ends[0]), at(ends[1])))
        }));
        self.notes
            .iter()
            .map(|note| {
                let size = [LETTER_PX * index(note.text.trim().chars().count()), LINE_PX];
                let placed = placed(at(note.at), size, plot, &taken);
                taken.push(placed.word);
                if placed.is_led {
                    taken.extend(along(placed.at, placed.nearest()));
                }
                placed
            })
            .collect()
    }

    /// The drawing alone, as the inside of an SVG.
    pub(crate) fn drawing(&self) -> Result<String, DrawError> {
        let mut svg = String::new();
        self.draw(&mut svg)?;
        Ok(cut_head(&svg, self.size, &self.title))
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
                            .map(|p| Circle::new((p[0], p[1]), 5 * ZOOM / 2, style)),
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
                    .zip(self.note_boxes())
                    .map(|(note, placed)| {
                        let [from, to] = placed.leader();
                        EmptyElement::at((note.at[0], note.at[1]))
                            + PathElement::new(vec![from, to], INK.mix(0.5).stroke_width(ZOOM))
                            + Text::new(note.text.trim().to_owned(), placed.corner(), font(NOTE_PX))
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

    /// A chart of dots with words, in a cloud of the given width (0 to 1) around the middle.
    fn cloud(count: u32, spread: f64, size: [u32; 2]) -> Chart {
        let mut seed = 1_u64;
        let mut place = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let share = f64::from(u32::try_from(seed >> 40).unwrap()) / f64::from(1_u32 << 24);
            5.0 + 10.0 * spread * (share - 0.5)
        };
        let points: Vec<[f64; 2]> = (0..count).map(|_| [place(), place()]).collect();
        Chart {
            title: String::new(),
            x: Scale::linear_from("x", [0.0, 10.0]),
            y: Scale::linear_from("y", [0.0, 10.0]),
            notes: points
                .iter()
                .map(|at| Note {
                    text: "utm-sky-vertex* 11 %".to_owned(),
                    at: *at,
                })
                .collect(),
            series: vec![Series::new("dots", 0, points).stroked(Stroke::Dots)],
            size,
        }
    }

    #[test]
    fn d_no_word_of_a_chart_is_cut_or_lies_on_another() {
        for (count, spread, size) in [
            (1, 0.0, [360, 260]),
            (16, 1.0, [900, 460]),
            (16, 0.2, [900, 460]),
            (16, 0.02, [900, 460]),
            (16, 1.0, [445, 330]),
            (16, 0.3, [445, 330]),
            (16, 0.05, [560, 360]),
            (5, 1.0, [360, 260]),
        ] {
            let chart = cloud(count, spread, size);
            let case = format!("{count} words, spread {spread}, {size:?}");
            let plot = [f64::from(size[0] - 72), f64::from(size[1] - 46)];
            let words: Vec<Box> = chart.note_boxes().iter().map(|p| p.word).collect();
            assert_eq!(words.len(), count as usize);
            for (i, word) in words.iter().enumerate() {
                assert!(word.is_within(plot), "{case}: {word:?} is cut");
                for other in &words[..i] {
                    assert!(!word.lies_on(other), "{case}: {word:?} on {other:?}");
                }
                for at in &chart.series[0].points {
                    let dot = [at[0] / 10.0 * plot[0], (1.0 - at[1] / 10.0) * plot[1]];
                    assert!(
                        !word.lies_on(&Box::around(dot, [4.0; 2])),
                        "{case}: on a dot"
                    );
                }
            }
        }
    }

    #[test]
    fn a_word_far_from_its_dot_is_led_to_it() {
        let chart = cloud(16, 0.02, [560, 360]);
        let placed = chart.note_boxes();
        assert!(!placed[0].is_led && placed.iter().any(|p| p.is_led));
        for p in placed.iter().filter(|p| p.is_led) {
            assert_ne!(p.leader()[1], (0, 0));
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
