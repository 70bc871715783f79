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
/// The sky formula.
pub const UTM_SKY: Part = part!("utm_sky.wgsl");
/// The frame's uniform and the light of a direction.
pub const SKY_FRAME: Part = part!("sky_frame.wgsl");
/// Finite paths.
pub const AERIAL: Part = part!("aerial.wgsl");
/// Perez's formula.
pub const PEREZ: Part = part!("perez.wgsl");
/// Entry points of the full-screen sky.
pub const SKY: Part = part!("sky.wgsl");
/// Entry points of the baked sky.
pub const BAKED: Part = part!("baked.wgsl");
/// Entry points of the dome.
pub const DOME: Part = part!("dome.wgsl");
/// Entry point of the depth-aware pass.
pub const COMPOSITE: Part = part!("composite.wgsl");

/// What every program starts with.
const COMMON: [Part; 6] = [COLOR, TONEMAP, UTM_SKY, SKY_FRAME, AERIAL, SKY];

/// The programs: name, and what stands after the common parts.
pub const PROGRAMS: [(&str, Option<Part>); 4] = [
    ("sky", None),
    ("baked", Some(BAKED)),
    ("dome", Some(DOME)),
    ("composite", Some(COMPOSITE)),
];

/// The text of a program.
#[must_use]
pub fn program(last: Option<Part>) -> String {
    COMMON
        .into_iter()
        .chain(last)
        .map(|(_, text)| text)
        .collect::<Vec<_>>()
        .join("\n")
}
