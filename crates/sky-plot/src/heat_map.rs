//! Tables of values as colors.

use plotters::prelude::*;

use crate::number::short;
use crate::page::escape;
use crate::png::byte;
use crate::scale::{Scale, index};
use crate::svg::{DrawError, INK, ZOOM, cut_head, drawing_error, font};

/// A table of values as colors.
#[derive(Clone, Debug)]
pub struct HeatMap {
    /// Heading above it.
    pub title: String,
    /// Caption and labels of the columns.
    pub x: (String, Vec<String>),
    /// Caption and labels of the rows, from below.
    pub y: (String, Vec<String>),
    /// Row by row from below; NaN for no value.
    pub values: Vec<f64>,
    /// Value of the last color.
    pub full_scale: f64,
    /// Shown size \[px\].
    pub size: [u32; 2],
}

impl HeatMap {
    /// The map with its heading; [`color_bar`] belongs to it.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn html(&self) -> Result<String, DrawError> {
        self.html_colored(|i| {
            let value = self.values[i];
            (!value.is_nan()).then(|| heat_color(value / self.full_scale))
        })
    }

    /// The map in other colors, by the index of a value; `None` leaves a cell empty.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn html_colored(
        &self,
        color: impl Fn(usize) -> Option<[u8; 3]>,
    ) -> Result<String, DrawError> {
        let mut svg = String::new();
        self.draw(&mut svg, color)?;
        Ok(format!(
            "<figure class=\"chart\"><figcaption>{}</figcaption>{}</figure>\n",
            escape(&self.title),
            cut_head(&svg, self.size, &self.title)
        ))
    }

    fn draw(
        &self,
        svg: &mut String,
        color: impl Fn(usize) -> Option<[u8; 3]>,
    ) -> Result<(), DrawError> {
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
#[must_use]
pub fn heat_color(share: f64) -> [u8; 3] {
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
        byte((a + t * (b - a)) / 255.0)
    })
}

/// The scale of [`heat_color`], from 0 to the full scale.
#[must_use]
pub fn color_bar(full_scale: f64, unit: &str) -> String {
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
