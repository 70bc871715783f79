//! What every drawing shares: the ink, the zoom and the words.

use plotters::prelude::*;
use thiserror::Error;

use crate::page::escape;

/// A chart that could not be drawn, and why.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("report: a chart could not be drawn: {0}")]
pub struct DrawError(String);

/// Drawn units per shown pixel.
pub(crate) const ZOOM: u32 = 4;

/// Stands for the ink while drawing; replaced by `currentColor`.
pub(crate) const INK: RGBColor = RGBColor(1, 2, 3);
const INK_SVG: &str = "#010203";

pub(crate) fn drawing_error(error: impl std::fmt::Display) -> DrawError {
    DrawError(error.to_string())
}

const ZOOMED_PX: f64 = 4.0;

#[expect(clippy::cast_possible_truncation, reason = "a few thousand at most")]
pub(crate) fn zoomed(px: f64) -> i32 {
    (px * ZOOMED_PX).round() as i32
}

pub(crate) fn font(px: f64) -> TextStyle<'static> {
    // plotters writes its size divided by 1.24.
    ("sans-serif", px * 1.24 * ZOOMED_PX)
        .into_font()
        .color(&INK)
}

pub(crate) fn cut_head(svg: &str, size: [u32; 2], title: &str) -> String {
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
