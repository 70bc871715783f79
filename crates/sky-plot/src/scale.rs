//! Axes: captions, ranges and round ticks.

use core::ops::Range;

use plotters::coord::ranged1d::{
    KeyPointHint, NoDefaultFormatting, Ranged, ReversibleRanged, ValueFormatter,
};

use crate::number::short;

/// An axis: its caption with unit, range and ticks.
#[derive(Clone, Debug)]
pub struct Scale {
    pub(crate) caption: String,
    pub(crate) range: [f64; 2],
    pub(crate) logarithmic: bool,
    pub(crate) ticks: Vec<f64>,
    labels: Option<Vec<String>>,
}

impl Scale {
    /// A linear axis over the values (finite ones), widened to whole ticks.
    #[must_use]
    pub fn linear(caption: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let [low, high] = extent(values);
        let step = tick_step(high - low);
        let range = [(low / step).floor() * step, (high / step).ceil() * step];
        Self::linear_from(caption, range)
    }

    /// A linear axis over a fixed range.
    #[must_use]
    pub fn linear_from(caption: &str, range: [f64; 2]) -> Self {
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
    #[must_use]
    pub fn logarithmic(caption: &str, values: impl IntoIterator<Item = f64>, decades: f64) -> Self {
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
    #[must_use]
    pub fn labeled(caption: &str, ticks: &[(f64, String)]) -> Self {
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
    #[must_use]
    pub const fn low(&self) -> f64 {
        self.range[0]
    }

    /// Places 0, 1, 2 … with a label each, as the rows or columns of a table have.
    pub(crate) fn places(caption: &str, labels: &[String], room: usize) -> Self {
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
    pub(crate) fn thinned(mut self, room: u32) -> Self {
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

    pub(crate) fn place(&self, value: f64) -> f64 {
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

pub(crate) fn index(i: usize) -> f64 {
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
}
