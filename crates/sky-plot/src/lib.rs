//! Rows to SVG and HTML: charts, heat maps, tables, pictures and the page around them.
//!
//! Simplifications: few kinds of chart, sizes in whole pixels, words measured by their count of
//! letters. Out of scope: what is drawn. Nothing here knows a sky, opens a file or prints.

pub mod chart;
pub mod heat_map;
pub mod number;
pub mod page;
pub mod png;
mod scale;
pub mod sheet;
mod svg;

pub use scale::Scale;
pub use svg::DrawError;
