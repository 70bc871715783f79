//! Two-dimensional tables that the CPU reads as a texture unit does: linear between texel centers,
//! clamped at the edges. And the pair of mappings between the unit interval and a texture's
//! coordinate.

use sky_science::shader_sky::ShaderTexture;

#[expect(
    clippy::cast_possible_truncation,
    reason = "tables and frames are f32, as in the shader"
)]
pub(crate) const fn single(x: f64) -> f32 {
    x as f32
}

pub(crate) fn singles<const N: usize>(x: [f64; N]) -> [f32; N] {
    x.map(single)
}

/// Texture coordinate of a place on the unit interval: 0 is the center of the first texel, 1 that of
/// the last one, so that nothing is extrapolated.
#[must_use]
pub fn texture_from_unit(unit: f64, texels: usize) -> f64 {
    let n = texels as f64;
    (unit * (n - 1.0) + 0.5) / n
}

/// The inverse of [`texture_from_unit`]. The pair printed with Hillaire 2020,
/// (u + 0.5/n)·n/(n + 1) and (u − 0.5/n)·n/(n − 1), is no inverse pair.
#[must_use]
pub fn unit_from_texture(coordinate: f64, texels: usize) -> f64 {
    let n = texels as f64;
    (coordinate * n - 0.5) / (n - 1.0)
}

/// Place on the unit interval of a texel's center.
pub(crate) fn unit_of_texel(index: usize, texels: usize) -> f64 {
    index as f64 / (texels - 1) as f64
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    width: usize,
    height: usize,
    texels: Vec<[f32; 4]>,
}

impl Table {
    /// Fills a table from places on the unit square.
    pub(crate) fn build(width: usize, height: usize, f: impl Fn(f64, f64) -> [f64; 4]) -> Self {
        let mut texels = Vec::with_capacity(width * height);
        for row in 0..height {
            for column in 0..width {
                let (x, y) = (unit_of_texel(column, width), unit_of_texel(row, height));
                texels.push(singles(f(x, y)));
            }
        }
        Self {
            width,
            height,
            texels,
        }
    }

    /// Value at a place of the unit square; outside it, that of the nearest edge.
    #[inline]
    pub(crate) fn at(&self, x: f32, y: f32) -> [f32; 4] {
        let (left, fx) = cell(x, self.width);
        let (top, fy) = cell(y, self.height);
        let first = top * self.width + left;
        let [a, b] = [self.texels[first], self.texels[first + 1]];
        let [c, d] = [
            self.texels[first + self.width],
            self.texels[first + self.width + 1],
        ];
        core::array::from_fn(|k| {
            let low = a[k] + fx * (b[k] - a[k]);
            let high = c[k] + fx * (d[k] - c[k]);
            low + fy * (high - low)
        })
    }

    pub(crate) fn texels_mut(&mut self) -> &mut [[f32; 4]] {
        &mut self.texels
    }

    pub(crate) fn texels(&self) -> &[[f32; 4]] {
        &self.texels
    }

    /// Bytes of the first `channels` of every texel.
    pub(crate) fn bytes(&self, channels: usize) -> usize {
        self.texels.len() * channels * size_of::<f32>()
    }

    /// The table as a texture; tables of one width may be stacked.
    pub(crate) fn stacked(tables: &[&Self]) -> ShaderTexture {
        let rows: usize = tables.iter().map(|t| t.height).sum();
        ShaderTexture {
            width: u32::try_from(tables[0].width).unwrap_or(u32::MAX),
            height: u32::try_from(rows).unwrap_or(u32::MAX),
            texels: tables.iter().flat_map(|t| &t.texels).copied().collect(),
        }
    }
}

#[inline]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to the table first; NaN becomes 0"
)]
fn cell(unit: f32, texels: usize) -> (usize, f32) {
    let place = unit.clamp(0.0, 1.0) * (texels - 1) as f32;
    let lower = (place as usize).min(texels - 2);
    (lower, place - lower as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_and_texture_coordinates_are_inverse() {
        for n in [2, 32, 257] {
            for i in 0..n {
                let unit = unit_of_texel(i, n);
                let coordinate = texture_from_unit(unit, n);
                assert!((unit_from_texture(coordinate, n) - unit).abs() < 1e-14);
                // a texel's center lies half a texel inside
                assert!((coordinate * n as f64 - (i as f64 + 0.5)).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn a_bilinear_function_is_read_exactly() {
        let f = |x: f64, y: f64| [1.0 + x, y, x * y, x - y];
        let table = Table::build(5, 9, f);
        for (x, y) in [(0.0_f32, 0.0_f32), (1.0, 1.0), (0.33, 0.71), (0.999, 0.001)] {
            let want = f(x.into(), y.into());
            for (v, w) in table.at(x, y).iter().zip(want) {
                assert!((f64::from(*v) - w).abs() < 1e-6);
            }
        }
        assert!((table.at(2.0, -1.0)[0] - 2.0).abs() < 1e-6, "clamped");
    }
}
