//! Several charts with one legend as one SVG file, dark ink on white.

use plotters::style::RGBColor;

use crate::chart::{Chart, Stroke};
use crate::page::escape;
use crate::svg::DrawError;

/// A chart and the upper left corner of its panel on the sheet \[px\].
pub type Panel<'a> = (&'a Chart, [u32; 2]);

/// Height of the legend, of a panel's title and of a line of footnotes \[px\].
pub const LEGEND_PX: u32 = 34;
/// Room above a chart for its title \[px\].
pub const TITLE_PX: u32 = 24;
const FOOTNOTE_PX: u32 = 18;

/// The file. The legend is that of the first panel; each panel's title stands above its chart.
///
/// # Errors
/// When a chart cannot be drawn.
pub fn sheet(panels: &[Panel<'_>], footnotes: &[&str]) -> Result<String, DrawError> {
    let mut out = String::new();
    let (mut width, mut height) = (0, LEGEND_PX);
    if let Some((first, _)) = panels.first() {
        out.push_str(&legend(first));
    }
    for (chart, [left, top]) in panels {
        let [w, h] = chart.size;
        let placed = format!(
            "<svg x=\"{left}\" y=\"{}\" width=\"{w}\" height=\"{h}\"",
            top + TITLE_PX
        );
        out.push_str(&words(left + 58, top + 17, 14, "bold", &chart.title));
        out.push_str(&chart.drawing()?.replacen("<svg", &placed, 1));
        width = width.max(left + w);
        height = height.max(top + TITLE_PX + h);
    }
    for line in footnotes {
        height += FOOTNOTE_PX;
        out.push_str(&words(12, height - 4, 12, "normal", line));
    }
    height += 8;
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" color=\"#222\"><rect width=\"100%\" height=\"100%\" \
         fill=\"white\"/>{out}</svg>\n"
    ))
}

fn words(left: u32, baseline: u32, px: u32, weight: &str, text: &str) -> String {
    format!(
        "<text x=\"{left}\" y=\"{baseline}\" font-family=\"sans-serif\" font-size=\"{px}\" \
         font-weight=\"{weight}\" fill=\"#222\">{}</text>",
        escape(text)
    )
}

fn legend(chart: &Chart) -> String {
    let mut out = String::new();
    let mut left = 58;
    for series in chart.series.iter().filter(|s| !s.name.is_empty()) {
        let RGBColor(r, g, b) = series.color.unwrap_or(RGBColor(34, 34, 34));
        let color = format!("rgb({r},{g},{b})");
        out.push_str(&match series.stroke {
            Stroke::Dots => format!(
                "<circle cx=\"{}\" cy=\"18\" r=\"4\" fill=\"{color}\"/>",
                left + 11
            ),
            stroke => format!(
                "<path d=\"M{left} 18h22\" stroke=\"{color}\" stroke-width=\"2\"{}/>",
                if stroke == Stroke::Dashed {
                    " stroke-dasharray=\"5 4\""
                } else {
                    ""
                }
            ),
        });
        out.push_str(&words(left + 28, 22, 13, "normal", &series.name));
        left += 60 + 8 * u32::try_from(series.name.chars().count()).unwrap_or(0);
    }
    out
}
