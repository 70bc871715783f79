//! The texts of the shaders. WGSL has no includes: a program is its parts one after the other.

/// A shader file: name and text.
pub type Part = (&'static str, &'static str);

macro_rules! part {
    ($name:literal, $text:ident) => {
        ($name, sky_shaders::$text)
    };
}

/// Yxy to linear sRGB.
pub const COLOR: Part = part!("color.wgsl", COLOR);
/// Exposure, tone curves, encoding.
pub const TONEMAP: Part = part!("tonemap.wgsl", TONEMAP);
/// Light in place of a picture, for float targets.
pub const LINEAR: Part = part!("linear.wgsl", LINEAR);
/// The sky formula.
pub const UTM_SKY: Part = part!("utm_sky.wgsl", UTM_SKY);
/// The frame's uniform and the light of a direction.
pub const SKY_FRAME: Part = part!("sky_frame.wgsl", SKY_FRAME);
/// Finite paths.
pub const AERIAL: Part = part!("aerial.wgsl", AERIAL);
/// Perez's formula.
pub const PEREZ: Part = part!("perez.wgsl", PEREZ);
/// The view and the light of sky and ground.
pub const SKY: Part = part!("sky.wgsl", SKY);
/// Entry points of the full-screen skies.
pub const BAKED: Part = part!("baked.wgsl", BAKED);
/// Entry points of the dome.
pub const DOME: Part = part!("dome.wgsl", DOME);
/// Entry point of the depth-aware pass.
pub const COMPOSITE: Part = part!("composite.wgsl", COMPOSITE);

/// The frame's numbers from the uniform.
pub const FRAME_UNIFORM: Part = part!("frame_uniform.wgsl", FRAME_UNIFORM);
/// The frame's numbers from the vertices, with entry points of full-screen skies.
pub const FLAT: Part = part!("flat.wgsl", FLAT);

/// What every program starts with, after the display.
const COMMON: [Part; 5] = [COLOR, UTM_SKY, SKY_FRAME, AERIAL, SKY];

/// A program: its name, and what stands after the common parts.
pub type Program = (&'static str, [Part; 2]);

/// Full-screen skies.
pub const SKY_PROGRAM: Program = ("sky", [FRAME_UNIFORM, BAKED]);
/// The dome.
pub const DOME_PROGRAM: Program = ("dome", [FRAME_UNIFORM, DOME]);
/// Air over a finished scene.
pub const COMPOSITE_PROGRAM: Program = ("composite", [FRAME_UNIFORM, COMPOSITE]);
/// Full-screen skies as a processor that plays GPU draws them fastest.
pub const FLAT_PROGRAM: Program = ("flat", [BAKED, FLAT]);

/// All programs.
pub const PROGRAMS: [Program; 4] = [SKY_PROGRAM, DOME_PROGRAM, COMPOSITE_PROGRAM, FLAT_PROGRAM];

/// The text of a program, for a float target that takes light or for one that shows a picture.
#[must_use]
pub fn text((_, last): Program, float_target: bool) -> String {
    let display = if float_target { LINEAR } else { TONEMAP };
    [display]
        .into_iter()
        .chain(COMMON)
        .chain(last)
        .map(|(_, text)| text)
        .collect::<Vec<_>>()
        .join("\n")
}
