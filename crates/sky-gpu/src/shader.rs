//! The texts of the shaders, for programs of ours and of yours.
//!
//! WGSL has no includes: a program is its parts one after the other. A material, glass or particle
//! shader of yours takes [`functions`] before its own text and binds [`crate::View::frame_group`]:
//!
//! ```
//! let mine = "
//! @group(0) @binding(0) var<uniform> eye: vec4<f32>; // yours
//! @fragment
//! fn my_fragment(@location(0) from_eye: vec3<f32>) -> @location(0) vec4<f32> {
//!     let object = vec3<f32>(120.0, 90.0, 60.0);     // its light [cd/m2]
//!     let air = air_before(from_eye, 0.001);         // world units are meters
//!     return vec4<f32>((air.transmittance.xyz * object + air.inscatter) * sky.exposure, 1.0);
//! }";
//! let text = sky_gpu::shader::functions(1) + mine; // the sky's numbers are bind group 1
//! # assert!(text.contains("@group(1) @binding(1) var<uniform> aerial"));
//! ```
//!
//! | function | what it answers |
//! |---|---|
//! | `air_before(place, km_per_unit) -> AerialPath` | the air before a place, given from the observer in the world's axes |
//! | `aerial_path(altitude_km, direction, distance_km) -> AerialPath` | the same for a local direction |
//! | `to_local(world) -> vec3` | a world direction in the local frame: toward the sun's azimuth, left of it, up |
//! | `is_sky(direction) -> bool` | whether a local direction is above the geometric horizon |
//! | `sky_light(direction)`, `ground_light(direction)`, `sun_disc(direction) -> vec3` | light in linear sRGB \[cd·m⁻²\] |
//!
//! An `AerialPath` is `transmittance: vec4<f32>` (red, green, blue, luminance) and `inscatter:
//! vec3<f32>` \[cd·m⁻²\]: light = transmittance · object + inscatter. `sky`, `aerial` and their members
//! are those of [`sky_core::uniforms`].

use sky_core::uniforms;

use crate::options::Output;

/// A shader file: name and text.
pub type Part = (&'static str, &'static str);

macro_rules! part {
    ($name:literal, $text:ident) => {
        ($name, sky_shaders::$text)
    };
}

/// The constants, the uniforms' structs and variables, in bind group 0.
pub const UNIFORMS: Part = part!("uniforms.wgsl", UNIFORMS);
/// Yxy to linear sRGB.
pub const COLOR: Part = part!("color.wgsl", COLOR);
/// Noise for quantization.
pub const DITHER: Part = part!("dither.wgsl", DITHER);
/// Exposure, tone curves, encoding.
pub const TONEMAP: Part = part!("tonemap.wgsl", TONEMAP);
/// Light in place of a picture, for float targets.
pub const LINEAR: Part = part!("linear.wgsl", LINEAR);
/// Roll-off and encoding of HDR displays.
pub const HDR: Part = part!("hdr.wgsl", HDR);
/// HDR10.
pub const HDR10: Part = part!("hdr10.wgsl", HDR10);
/// scRGB.
pub const SCRGB: Part = part!("scrgb.wgsl", SCRGB);
/// The sky formula.
pub const UTM_SKY: Part = part!("utm_sky.wgsl", UTM_SKY);
/// The light of a direction, the sun's disc.
pub const SKY_FRAME: Part = part!("sky_frame.wgsl", SKY_FRAME);
/// Finite paths.
pub const AERIAL: Part = part!("aerial.wgsl", AERIAL);
/// The light of sky and ground, and of objects behind air.
pub const PICTURE: Part = part!("picture.wgsl", PICTURE);
/// Perez's formula.
pub const PEREZ: Part = part!("perez.wgsl", PEREZ);
/// The camera.
pub const VIEW: Part = part!("view.wgsl", VIEW);
/// Entry points of the full-screen skies.
pub const BAKED: Part = part!("baked.wgsl", BAKED);
/// Entry points of the dome.
pub const DOME: Part = part!("dome.wgsl", DOME);
/// Where the pixels of a finished scene are.
pub const SCENE: Part = part!("scene.wgsl", SCENE);
/// Entry points of the depth-aware pass.
pub const COMPOSITE: Part = part!("composite.wgsl", COMPOSITE);
/// The same for a depth with several samples.
pub const COMPOSITE_MULTISAMPLED: Part =
    part!("composite_multisampled.wgsl", COMPOSITE_MULTISAMPLED);

/// What a shader of the user needs of ours, after the uniforms.
const FUNCTIONS: [Part; 5] = [COLOR, UTM_SKY, SKY_FRAME, AERIAL, PICTURE];

/// A program: its name, and what stands after the common parts.
#[derive(Clone, Copy, Debug)]
pub struct Program {
    /// Its name.
    pub name: &'static str,
    /// Its own parts.
    pub parts: &'static [Part],
    /// Whether GLSL ES 3.00, and so WebGL 2, can express it.
    pub in_glsl_es: bool,
}

/// Full-screen skies.
pub const SKY_PROGRAM: Program = Program {
    name: "sky",
    parts: &[BAKED],
    in_glsl_es: true,
};
/// The dome.
pub const DOME_PROGRAM: Program = Program {
    name: "dome",
    parts: &[DOME],
    in_glsl_es: true,
};
/// Air over a finished scene.
pub const COMPOSITE_PROGRAM: Program = Program {
    name: "composite",
    parts: &[SCENE, COMPOSITE],
    in_glsl_es: true,
};
/// Air over a finished scene whose depth has several samples.
pub const MULTISAMPLED_PROGRAM: Program = Program {
    name: "composite_multisampled",
    parts: &[SCENE, COMPOSITE_MULTISAMPLED],
    in_glsl_es: false,
};

/// All programs.
pub const PROGRAMS: [Program; 4] = [
    SKY_PROGRAM,
    DOME_PROGRAM,
    COMPOSITE_PROGRAM,
    MULTISAMPLED_PROGRAM,
];

/// The parts that turn light into the pixel of an output.
const fn display(output: Output) -> &'static [Part] {
    match output {
        Output::Linear => &[LINEAR],
        Output::Display => &[DITHER, TONEMAP],
        Output::Hdr10 { .. } => &[DITHER, HDR, HDR10],
        Output::ScRgb { .. } => &[HDR, SCRGB],
    }
}

fn joined(parts: impl Iterator<Item = Part>) -> String {
    parts.map(|(_, text)| text).collect::<Vec<_>>().join("\n")
}

/// The text of a program for an output.
#[must_use]
pub fn text(program: Program, output: Output) -> String {
    joined(
        [UNIFORMS]
            .into_iter()
            .chain(display(output).iter().copied())
            .chain(FUNCTIONS)
            .chain([VIEW])
            .chain(program.parts.iter().copied()),
    )
}

/// Our functions for a shader of yours, the sky's numbers in a bind group of your choice. The names
/// `sky` and `aerial` are taken.
#[must_use]
pub fn functions(group: u32) -> String {
    let mut text = uniforms::declarations();
    text.push_str(&uniforms::bindings(group, &["sky", "aerial"]));
    text + &joined(FUNCTIONS.into_iter())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn module(text: &str) -> naga::Module {
        let module = naga::front::wgsl::parse_str(text)
            .unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
        naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::empty(),
        )
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
        module
    }

    #[test]
    fn rust_and_wgsl_lay_the_uniforms_out_alike() {
        let text = text(SKY_PROGRAM, Output::Linear);
        let module = module(&text);
        for (name, expected, bytes) in [
            (
                "SkyUniform",
                uniforms::SkyUniform::MEMBERS,
                uniforms::SkyUniform::BYTES,
            ),
            (
                "AerialUniform",
                uniforms::AerialUniform::MEMBERS,
                uniforms::AerialUniform::BYTES,
            ),
            (
                "ViewUniform",
                uniforms::ViewUniform::MEMBERS,
                uniforms::ViewUniform::BYTES,
            ),
        ] {
            let (_, found) = module
                .types
                .iter()
                .find(|(_, t)| t.name.as_deref() == Some(name))
                .expect("the struct");
            let naga::TypeInner::Struct { members, span } = &found.inner else {
                panic!("{name}: no struct");
            };
            assert_eq!(*span as usize, bytes, "{name}");
            assert_eq!(members.len(), expected.len(), "{name}");
            for (member, expected) in members.iter().zip(expected) {
                assert_eq!(member.name.as_deref(), Some(expected.name));
                assert_eq!(member.offset as usize, expected.offset, "{}", expected.name);
                let size = module.types[member.ty].inner.size(module.to_ctx());
                assert_eq!(size as usize, expected.bytes, "{}", expected.name);
            }
        }
    }

    /// A material, glass and particles of a stranger, each with bind groups of its own.
    #[test]
    fn shaders_of_a_user_compile_with_our_functions() {
        let material = "
            struct Mine { clip_from_world: mat4x4<f32>, tint: vec4<f32> }
            @group(0) @binding(0) var<uniform> mine: Mine;
            struct Varying { @builtin(position) position: vec4<f32>, @location(0) place: vec3<f32> }
            @vertex fn my_vertex(@location(0) place: vec3<f32>) -> Varying {
                return Varying(mine.clip_from_world * vec4<f32>(place, 1.0), place);
            }
            @fragment fn my_fragment(in: Varying) -> @location(0) vec4<f32> {
                let air = air_before(in.place, 0.001);
                let lit = air.transmittance.xyz * mine.tint.xyz + air.inscatter;
                return vec4<f32>(lit * sky.exposure, 1.0);
            }";
        let glass = "
            @fragment fn glass(@location(0) seen: vec3<f32>, @location(1) normal: vec3<f32>)
                -> @location(0) vec4<f32> {
                let mirrored = to_local(reflect(seen, normalize(normal)));
                var light = ground_light(mirrored);
                if (is_sky(mirrored)) {
                    light = sky_light(mirrored) + sun_disc(mirrored);
                }
                return vec4<f32>(0.04 * light * sky.exposure, 0.9);
            }";
        let particle = "
            @vertex fn particle(@location(0) place: vec3<f32>) -> @builtin(position) vec4<f32> {
                let path = aerial_path(sky.altitude_km, to_local(place), 2.0);
                return vec4<f32>(place.xy, 0.0, 1.0 + path.transmittance.w);
            }";
        for (group, text) in [(1, material), (0, glass), (3, particle)] {
            let module = module(&(functions(group) + text));
            let groups: Vec<u32> = module
                .global_variables
                .iter()
                .filter(|(_, v)| matches!(v.name.as_deref(), Some("sky" | "aerial")))
                .filter_map(|(_, v)| v.binding.map(|b| b.group))
                .collect();
            assert_eq!(groups, [group, group]);
        }
    }

    #[test]
    fn every_program_compiles_for_every_output() {
        for program in PROGRAMS {
            for output in Output::ALL {
                module(&text(program, output));
            }
        }
    }
}
