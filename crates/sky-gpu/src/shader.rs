//! The texts of the shaders. WGSL has no includes: a program is its parts one after the other.

/// A shader file: name and text.
pub type Part = (&'static str, &'static str);

macro_rules! part {
    ($name:literal) => {
        ($name, include_str!(concat!("../../../shaders/", $name)))
    };
}

/// Yxy to linear sRGB.
pub const COLOR: Part = part!("color.wgsl");
/// Exposure, tone curves, encoding.
pub const TONEMAP: Part = part!("tonemap.wgsl");
/// Light in place of a picture, for float targets.
pub const LINEAR: Part = part!("linear.wgsl");
/// The sky formula.
pub const UTM_SKY: Part = part!("utm_sky.wgsl");
/// The frame's uniform and the light of a direction.
pub const SKY_FRAME: Part = part!("sky_frame.wgsl");
/// Finite paths.
pub const AERIAL: Part = part!("aerial.wgsl");
/// Perez's formula.
pub const PEREZ: Part = part!("perez.wgsl");
/// The view and the light of sky and ground.
pub const SKY: Part = part!("sky.wgsl");
/// Entry points of the full-screen skies.
pub const BAKED: Part = part!("baked.wgsl");
/// Entry points of the dome.
pub const DOME: Part = part!("dome.wgsl");
/// Entry point of the depth-aware pass.
pub const COMPOSITE: Part = part!("composite.wgsl");

/// What every program starts with, after the display.
const COMMON: [Part; 5] = [COLOR, UTM_SKY, SKY_FRAME, AERIAL, SKY];

/// The programs: name, and what stands after the common parts.
pub const PROGRAMS: [(&str, Part); 3] = [("sky", BAKED), ("dome", DOME), ("composite", COMPOSITE)];

/// The text of a program, for a float target that takes light or for one that shows a picture.
#[must_use]
pub fn program(last: Part, float_target: bool) -> String {
    let display = if float_target { LINEAR } else { TONEMAP };
    [display]
        .into_iter()
        .chain(COMMON)
        .chain([last])
        .map(|(_, text)| text)
        .collect::<Vec<_>>()
        .join("\n")
}
