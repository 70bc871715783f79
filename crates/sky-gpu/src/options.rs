//! What a renderer is made for: target, output, depth, samples.

use wgpu::TextureFormat;

/// What the numbers of a target mean. Named, for a format does not tell: a float target may take light
/// or be a display's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Output {
    /// Linear sRGB light times the exposure, for float targets and a tone curve of yours. What the
    /// target cannot hold is dimmed with its color kept, so that no pixel becomes infinite.
    Linear,
    /// A picture for an sRGB display: exposure, tone curve, encoding (unless the format encodes by
    /// itself), noise that hides the levels.
    #[default]
    Display,
    /// HDR10: Rec.2020, perceptual quantizer, for `Rgb10a2Unorm`. Highlights roll off below the peak;
    /// the tone curve is not used.
    Hdr10 {
        /// What an exposed 1 is shown with \[cd·m⁻²\]; ITU-R BT.2408 has 203.
        white_nits: f32,
        /// The brightest that the display shows \[cd·m⁻²\].
        peak_nits: f32,
    },
    /// scRGB: linear, 1 is 80 cd·m⁻², for `Rgba16Float`. Highlights as in HDR10.
    ScRgb {
        /// What an exposed 1 is shown with \[cd·m⁻²\].
        white_nits: f32,
        /// The brightest that the display shows \[cd·m⁻²\].
        peak_nits: f32,
    },
}

impl Output {
    /// Every kind, HDR with usual numbers.
    pub const ALL: [Self; 4] = [
        Self::Linear,
        Self::Display,
        Self::Hdr10 {
            white_nits: 203.0,
            peak_nits: 1000.0,
        },
        Self::ScRgb {
            white_nits: 203.0,
            peak_nits: 1000.0,
        },
    ];

    /// White and peak of an HDR display \[cd·m⁻²\].
    pub(crate) const fn nits(self) -> [f32; 2] {
        match self {
            Self::Linear | Self::Display => [0.0; 2],
            Self::Hdr10 {
                white_nits,
                peak_nits,
            }
            | Self::ScRgb {
                white_nits,
                peak_nits,
            } => [white_nits, peak_nits],
        }
    }
}

/// What a renderer is made for.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyRendererOptions {
    /// Format of the targets that are drawn to.
    pub target_format: TextureFormat,
    /// What the target's numbers mean.
    pub output: Output,
    /// Depth and stencil state of the sky, where the pass has a depth attachment; [`sky_depth`] makes
    /// the usual one.
    pub depth_stencil: Option<wgpu::DepthStencilState>,
    /// Samples of the targets: 1, or 4 where the device has them.
    pub sample_count: u32,
    /// Whether the depth that [`crate::SkyRenderer::composite`] reads is multisampled. WebGL 2 cannot.
    pub scene_depth_multisampled: bool,
}

impl SkyRendererOptions {
    /// For a target without depth and with one sample.
    #[must_use]
    pub const fn new(target_format: TextureFormat, output: Output) -> Self {
        Self {
            target_format,
            output,
            depth_stencil: None,
            sample_count: 1,
            scene_depth_multisampled: false,
        }
    }
}

/// The sky at the far depth, tested and not written: it may be drawn before the scene, or after it
/// where nothing is. Reversed depth has its far plane at 0 and grows toward the eye. The camera's
/// `far_depth` must agree.
#[must_use]
pub fn sky_depth(format: TextureFormat, reversed: bool) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format,
        depth_write_enabled: Some(false),
        depth_compare: Some(if reversed {
            wgpu::CompareFunction::GreaterEqual
        } else {
            wgpu::CompareFunction::LessEqual
        }),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// The largest finite number that every component of a format holds.
pub(crate) const fn largest(format: TextureFormat) -> f32 {
    match format {
        TextureFormat::Rgba16Float | TextureFormat::Rg16Float | TextureFormat::R16Float => 65504.0,
        // the blue component's; red and green hold 65 024
        TextureFormat::Rg11b10Ufloat => 64512.0,
        // 511/512 · 2^16
        TextureFormat::Rgb9e5Ufloat => 65408.0,
        TextureFormat::Rgba32Float => f32::MAX,
        _ => 1.0,
    }
}

/// Distance of two levels of a format; 0 where there are none to hide.
pub(crate) const fn dither_step(format: TextureFormat) -> f32 {
    match format {
        TextureFormat::Rgba8Unorm
        | TextureFormat::Rgba8UnormSrgb
        | TextureFormat::Bgra8Unorm
        | TextureFormat::Bgra8UnormSrgb => 1.0 / 255.0,
        TextureFormat::Rgb10a2Unorm => 1.0 / 1023.0,
        _ => 0.0,
    }
}
