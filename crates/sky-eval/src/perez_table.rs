//! A table of a Perez form on the GPU: the nodes around a frame's place go to the shader, which blends
//! their lights as [`sky_science::perez_sky::PerezFrame`] does.
//!
//! For comparison: the renderer draws tables of the extended form alone.

use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain, OutsideDomain};
use sky_core::direction::SkyDirection;
use sky_core::extended::angle;
use sky_core::lut::Interpolation;
use sky_science::perez_sky::{PerezSky, perez};
use sky_science::shader_sky::{ShaderFrame, ShaderSky};
use sky_science::sky_model::{SkyError, SkyModel};

/// A sky whose formula is one of Perez's.
#[derive(Debug)]
pub(crate) struct PerezTable(PerezSky);

impl PerezTable {
    pub(crate) const fn new(sky: PerezSky) -> Self {
        Self(sky)
    }
}

impl SkyModel for PerezTable {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn domain(&self) -> &Domain {
        self.0.domain()
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        self.0.yxy_map(conditions, directions)
    }
}

impl ShaderSky for PerezTable {
    fn shader(&self) -> &'static str {
        sky_shaders::baselines::PEREZ_TABLE
    }

    fn shader_frame(&self, conditions: &Conditions) -> Result<ShaderFrame, OutsideDomain> {
        let nodes = self.0.frame(conditions)?;
        let [sin_sun, cos_sun] = nodes.sun;
        let sun_zenith = angle(sin_sun, cos_sun);
        let (scale_heights, root, lowest) = if nodes.plane_parallel {
            (0.0, 0.0, 0.0)
        } else {
            let radii = nodes.radii;
            (
                radii.in_scale_heights[0],
                radii.half_roots[0],
                nodes.cos_horizon,
            )
        };
        let linear = nodes.interpolation == Interpolation::ReportLagrange;
        let mut uniforms = vec![
            [sin_sun, 0.0, cos_sun, 0.0],
            [scale_heights, root, lowest, f32::from(u8::from(linear))],
        ];
        for (weight, channels) in nodes
            .weights
            .iter()
            .zip(&nodes.coefficients)
            .take(nodes.corners)
        {
            uniforms[0][3] += 1.0;
            let [luminance, x, y] = channels;
            uniforms.extend(channels.map(|[_, a, b, c, d, _]| [a, b, c, d]));
            uniforms.push([luminance[5], x[5], y[5], *weight]);
            let [luminance, x, y] = channels.map(|c| c[0] / perez(&c, 1.0, sun_zenith));
            uniforms.push([luminance, x, y, 0.0]);
        }
        Ok(ShaderFrame {
            uniforms,
            texture: None,
        })
    }

    fn table_bytes(&self) -> usize {
        self.0.lut().encode().len()
    }
}
