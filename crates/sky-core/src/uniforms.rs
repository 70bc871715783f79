//! What the shaders read: three uniform buffers with named members, and the constants that shaders and
//! Rust share.
//!
//! Everything here is plain numbers, for any engine, any version of wgpu, C and the browser: fill a
//! [`SkyUniform`] and an [`AerialUniform`] once for a frame and a [`ViewUniform`] once for a camera,
//! upload what `as_bytes` gives, and bind them as [`bindings`] says. The tables below are the one
//! source: Rust's structs, their layout ([`SkyUniform::MEMBERS`] with offsets, units and meanings) and
//! the WGSL text ([`wgsl`]; for group 0 also the file `shaders/uniforms.wgsl`) are made from them.
//!
//! Members are `f32`, vectors and matrices of it and arrays of `vec4`, placed so that C's, std140's and
//! WGSL's rules agree: no padding anywhere. Flags are 0 or 1.
//!
//! ```
//! use sky_core::uniforms::{SkyUniform, wgsl};
//! let exposure = SkyUniform::MEMBERS.iter().find(|m| m.name == "exposure").ok_or("a member")?;
//! assert_eq!(exposure.unit, "m²·cd⁻¹");
//! assert!(exposure.offset + exposure.bytes <= SkyUniform::BYTES);
//! assert!(wgsl(0).contains("exposure: f32,"));
//! # Ok::<(), &str>(())
//! ```

use core::fmt::Write as _;

use crate::aerial::{AerialFrame, SCATTERED_BEFORE, SECTIONS};
use crate::extended::{SCALE_HEIGHTS_KM, TERMS};
use crate::extinction::{LEVEL_STEP_KM, LEVELS};
use crate::hdr::{SCRGB_UNIT_NITS, SHOULDER};
use crate::picture::Picture;
use crate::quantity::{EARTH_RADIUS_KM, single};
use crate::sun::LIMB_DARKENING;
use crate::utm_sky::{HORIZON_SLACK, LOWEST_RING_BEND, MAX_LAYERS};

/// Texels of a baked sky, across and up.
pub const BAKED_SIZE: [u32; 2] = [160, 192];
/// Rows of a baked sky, the lowest, that hold the ground.
pub const BAKED_GROUND: u32 = 40;
/// Rings of the dome below the horizon.
pub const GROUND_RINGS: u16 = 6;

/// A number that shaders and Rust share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant {
    /// Its name in WGSL.
    pub name: &'static str,
    /// The number.
    pub value: Value,
    /// What it is, with its unit.
    pub meaning: &'static str,
}

/// A constant's type and value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// `f32`.
    Float(f32),
    /// `u32`: a number of things.
    Count(usize),
}

const fn float(name: &'static str, value: f32, meaning: &'static str) -> Constant {
    Constant {
        name,
        value: Value::Float(value),
        meaning,
    }
}

const fn count(name: &'static str, value: usize, meaning: &'static str) -> Constant {
    Constant {
        name,
        value: Value::Count(value),
        meaning,
    }
}

/// Every number that shaders and Rust share.
pub const CONSTANTS: [Constant; 18] = [
    float(
        "EARTH_RADIUS_KM",
        single(EARTH_RADIUS_KM),
        "radius of the Earth [km]",
    ),
    float(
        "AIR_SCALE_HEIGHT_KM",
        single(SCALE_HEIGHTS_KM[0]),
        "scale height of the air in the formula's air mass [km]",
    ),
    float(
        "HAZE_SCALE_HEIGHT_KM",
        single(SCALE_HEIGHTS_KM[1]),
        "scale height of the haze in the formula's air mass [km]",
    ),
    count("TERMS", TERMS, "products of the formula"),
    float(
        "LOWEST_RING_BEND",
        single(LOWEST_RING_BEND),
        "width, in the cosine, of the bend to the lowest fitted ring",
    ),
    float(
        "HORIZON_SLACK",
        HORIZON_SLACK,
        "how far below the horizon, in the cosine, a direction still counts as sky",
    ),
    float(
        "LIMB_DARKENING",
        LIMB_DARKENING,
        "how much darker than its center the limb of the sun is",
    ),
    float(
        "SHOULDER",
        SHOULDER,
        "share of an HDR display's peak above which highlights roll off",
    ),
    float(
        "SCRGB_UNIT_NITS",
        SCRGB_UNIT_NITS,
        "what scRGB shows a 1 with [cd/m2]",
    ),
    count("LEVELS", LEVELS, "levels of the air's density"),
    float(
        "LEVEL_STEP_KM",
        single(LEVEL_STEP_KM),
        "distance of the levels [km]",
    ),
    float(
        "TOP_OF_AIR_KM",
        single(LEVEL_STEP_KM) * (LEVELS - 1) as f32,
        "altitude of the highest level [km]",
    ),
    float(
        "SECTIONS",
        SECTIONS as f32,
        "sections of a path, descent and rise each",
    ),
    float(
        "SCATTERED_BEFORE",
        SCATTERED_BEFORE,
        "light scattered before, as a share of that scattered once, in clear air",
    ),
    float(
        "BAKED_WIDTH",
        BAKED_SIZE[0] as f32,
        "texels of a baked sky across",
    ),
    float(
        "BAKED_HEIGHT",
        BAKED_SIZE[1] as f32,
        "texels of a baked sky up",
    ),
    float(
        "BAKED_GROUND",
        BAKED_GROUND as f32,
        "of these the lowest for the ground",
    ),
    count(
        "GROUND_RINGS",
        GROUND_RINGS as usize,
        "rings of the dome below the horizon",
    ),
];

/// A member of a uniform as it lies in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its name, in Rust and in WGSL.
    pub name: &'static str,
    /// Its type.
    pub kind: Kind,
    /// Bytes from the start of the uniform.
    pub offset: usize,
    /// Bytes that it takes.
    pub bytes: usize,
    /// Its unit; 1 where it has none.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
}

/// A type of a member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `f32`.
    F32,
    /// `vec2<f32>`.
    Vec2,
    /// `vec3<f32>`; another member fills the fourth place.
    Vec3,
    /// `vec4<f32>`.
    Vec4,
    /// `mat4x4<f32>`, column by column.
    Mat4,
    /// `array<vec4<f32>, N>`.
    Array(usize),
}

impl Kind {
    /// Bytes of a value.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::Vec2 => 8,
            Self::Vec3 => 12,
            Self::Vec4 => 16,
            Self::Mat4 => 64,
            Self::Array(length) => 16 * length,
        }
    }

    /// What an offset must be a multiple of, by WGSL's and std140's rules.
    #[must_use]
    pub const fn alignment(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::Vec2 => 8,
            Self::Vec3 | Self::Vec4 | Self::Mat4 | Self::Array(_) => 16,
        }
    }
}

impl core::fmt::Display for Kind {
    /// As WGSL has it.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::F32 => f.write_str("f32"),
            Self::Vec2 => f.write_str("vec2<f32>"),
            Self::Vec3 => f.write_str("vec3<f32>"),
            Self::Vec4 => f.write_str("vec4<f32>"),
            Self::Mat4 => f.write_str("mat4x4<f32>"),
            Self::Array(length) => write!(f, "array<vec4<f32>, {length}>"),
        }
    }
}

/// The numbers of a member, in order.
trait Floats {
    fn each(&self, to: &mut impl FnMut(f32));
}

impl Floats for f32 {
    fn each(&self, to: &mut impl FnMut(Self)) {
        to(*self);
    }
}

impl<T: Floats, const N: usize> Floats for [T; N] {
    fn each(&self, to: &mut impl FnMut(f32)) {
        for part in self {
            part.each(to);
        }
    }
}

macro_rules! rust_type {
    (f32) => {
        f32
    };
    (vec2) => {
        [f32; 2]
    };
    (vec3) => {
        [f32; 3]
    };
    (vec4) => {
        [f32; 4]
    };
    (mat4) => {
        [[f32; 4]; 4]
    };
    (array $count:expr) => {
        [[f32; 4]; $count]
    };
}

macro_rules! kind {
    (f32) => {
        Kind::F32
    };
    (vec2) => {
        Kind::Vec2
    };
    (vec3) => {
        Kind::Vec3
    };
    (vec4) => {
        Kind::Vec4
    };
    (mat4) => {
        Kind::Mat4
    };
    (array $count:expr) => {
        Kind::Array($count)
    };
}

/// Declares a uniform: for each member its name, type, unit and meaning.
macro_rules! uniform {
    ($(#[$doc:meta])* $name:ident {
        $($member:ident: $kind:ident $(($count:expr))?, $unit:literal, $meaning:literal;)*
    }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $(
                #[doc = concat!("\\[", $unit, "\\] ", $meaning, ".")]
                pub $member: rust_type!($kind $($count)?),
            )*
        }

        impl $name {
            /// Its size.
            pub const BYTES: usize = size_of::<Self>();

            /// Its members in order.
            pub const MEMBERS: &[Member] = &[$(Member {
                name: stringify!($member),
                kind: kind!($kind $($count)?),
                offset: core::mem::offset_of!(Self, $member),
                bytes: size_of::<rust_type!($kind $($count)?)>(),
                unit: $unit,
                meaning: $meaning,
            }),*];

            /// It as it is uploaded, in the byte order of the machine.
            #[must_use]
            pub fn as_bytes(&self) -> [u8; Self::BYTES] {
                let mut bytes = [0; Self::BYTES];
                let mut places = bytes.chunks_exact_mut(4);
                let mut put = |float: f32| {
                    if let Some(place) = places.next() {
                        place.copy_from_slice(&float.to_ne_bytes());
                    }
                };
                $(self.$member.each(&mut put);)*
                bytes
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    $($member: <rust_type!($kind $($count)?) as Zero>::ZERO,)*
                }
            }
        }

        // a member out of its place would be read as another
        const _: () = assert!(is_laid_out($name::MEMBERS, $name::BYTES));
    };
}

trait Zero {
    const ZERO: Self;
}

impl Zero for f32 {
    const ZERO: Self = 0.0;
}

impl<T: Zero + Copy, const N: usize> Zero for [T; N] {
    const ZERO: Self = [T::ZERO; N];
}

/// Whether members follow each other without gaps, each where WGSL's rules put it.
const fn is_laid_out(members: &[Member], bytes: usize) -> bool {
    let mut end = 0;
    let mut i = 0;
    while i < members.len() {
        let Member {
            kind,
            offset,
            bytes,
            ..
        } = members[i];
        if offset != end || offset % kind.alignment() != 0 || bytes != kind.bytes() {
            return false;
        }
        end += bytes;
        i += 1;
    }
    end == bytes && end % 16 == 0
}

uniform! {
    /// The sky of one observer, haze and sun, and how it is displayed.
    SkyUniform {
        coefficients: array(TERMS), "1", "of ln Y, x and y for each product of the formula; the fourth place is not read";
        radii: vec2, "1", "distance from the Earth's center in scale heights of air and of haze";
        radii_roots: vec2, "1", "square roots of half of these";
        sun_sin_cos: vec2, "1", "sine and cosine of the sun's zenith angle";
        cos_horizon: f32, "1", "cosine of the geometric horizon's zenith angle";
        cos_lowest: f32, "1", "cosine of the zenith angle of the lowest ring that the table was fitted to";
        local_x: vec3, "1", "the world's direction level toward the sun's azimuth";
        altitude_km: f32, "km", "the observer's altitude";
        local_y: vec3, "1", "the world's direction level, left of the sun";
        sin_sun_radius: f32, "1", "sine of the sun's angular radius";
        local_z: vec3, "1", "the world's direction up at the observer";
        outside_domain: f32, "flag", "paints stripes in place of the sky";
        sun_upper: vec3, "cd·m⁻²", "light of the disc's center through the air at its upper limb, linear sRGB";
        sun_upper_cosine: f32, "1", "cosine of the upper limb's zenith angle";
        sun_lower: vec3, "cd·m⁻²", "the same at its lower limb, or at the horizon";
        sun_lower_cosine: f32, "1", "cosine of the lower limb's zenith angle";
        ground: vec3, "cd·m⁻²", "light of the ground, linear sRGB";
        baked_scale: f32, "m²·cd⁻¹", "brings light into the range of the baked sky's half floats";
        exposure: f32, "m²·cd⁻¹", "multiplies light before it is displayed";
        scene_exposure: f32, "m²·cd⁻¹", "what the colors of a finished scene were multiplied with";
        largest: f32, "1", "largest number that a target of linear light holds";
        tone: f32, "1", "the tone curve of a display: 0 none, 1 Reinhard, 2 ACES, 3 neutral";
        dither_step: f32, "1", "distance of two levels of the target, 0 for no noise";
        target_encodes: f32, "flag", "the target encodes sRGB by itself";
        white_nits: f32, "cd·m⁻²", "what an HDR display shows an exposed 1 with";
        peak_nits: f32, "cd·m⁻²", "the brightest that an HDR display shows";
    }
}

uniform! {
    /// The air between an observer and objects for one haze and sun: the sky of every altitude, and
    /// the extinction at four wavelengths.
    AerialUniform {
        coefficients: array(TERMS * MAX_LAYERS), "1", "of ln Y, x and y for each product, altitude node by altitude node";
        node_altitudes_km: array(MAX_LAYERS / 4), "km", "altitudes of the nodes, four a vector";
        air_per_km: vec4, "km⁻¹", "scattering coefficient of the air at the ground, at four wavelengths";
        gas_per_km: vec4, "km⁻¹", "absorption coefficient of the gases where they are densest";
        haze_per_km: vec4, "km⁻¹", "extinction coefficient of the haze at the ground";
        stratosphere_per_km: vec4, "km⁻¹", "extinction coefficient of the stratospheric aerosol where it is densest";
        red_weights: vec4, "1", "shares of the wavelengths in red";
        green_weights: vec4, "1", "shares of the wavelengths in green";
        blue_weights: vec4, "1", "shares of the wavelengths in blue";
        luminance_weights: vec4, "1", "shares of the wavelengths in luminance";
        levels: array(LEVELS), "1", "logarithm of the air's relative density, relative densities of gas and stratospheric aerosol, 0";
        sun_sin_cos: vec2, "1", "sine and cosine of the sun's zenith angle";
        node_count: f32, "1", "altitude nodes in use, at least 2";
        haze_per_scale_height: f32, "km⁻¹", "one over the scale height of the haze";
        rise_ends: f32, "1", "ends of the sections of a rise: a bound that drivers cannot unroll, SECTIONS";
        path_ends: f32, "1", "ends of the sections of a path, SECTIONS and 3";
        unused: vec2, "1", "0";
    }
}

uniform! {
    /// A camera.
    ViewUniform {
        clip_to_world: mat4, "1", "from clip space (x, y, depth, 1) to world directions, translation left out; of a panorama from right, forward and up";
        world_to_clip: mat4, "1", "its inverse";
        ray_x: vec3, "1", "world direction of a ray: ray_x times clip x";
        projection: f32, "1", "0 a matrix, 1 fisheye, 2 equirectangular";
        ray_y: vec3, "1", "and ray_y times clip y";
        aspect: f32, "1", "width over height of a fisheye picture";
        ray_center: vec3, "1", "and ray_center";
        far_depth: f32, "1", "depth in clip space of what is infinitely far";
        viewport_origin: vec2, "pixel", "first pixel of the viewport";
        km_per_unit: f32, "km", "length of a unit of the world";
        depth_is_distance: f32, "flag", "a scene's depth is a distance in km, 0 for the sky";
        dome_rings: f32, "1", "rings of the dome from the zenith to the horizon";
        dome_spokes: f32, "1", "corners of a ring";
        dome_seam_azimuth: f32, "rad", "azimuth from the sun where the dome is cut";
        rays_are_parallel: f32, "flag", "the projection is orthographic";
    }
}

/// How light becomes a pixel of a target. Plain numbers; the defaults leave linear light as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplaySettings {
    /// [`SkyUniform::exposure`].
    pub exposure: f32,
    /// [`SkyUniform::scene_exposure`].
    pub scene_exposure: f32,
    /// [`SkyUniform::largest`].
    pub largest: f32,
    /// [`SkyUniform::tone`], by [`crate::tonemap::Tone::index`].
    pub tone: f32,
    /// [`SkyUniform::dither_step`].
    pub dither_step: f32,
    /// [`SkyUniform::target_encodes`].
    pub target_encodes: bool,
    /// [`SkyUniform::white_nits`].
    pub white_nits: f32,
    /// [`SkyUniform::peak_nits`].
    pub peak_nits: f32,
}

impl Default for DisplaySettings {
    fn default() -> Self {
        Self {
            exposure: 1.0,
            scene_exposure: 1.0,
            largest: f32::MAX,
            tone: 0.0,
            dither_step: 0.0,
            target_encodes: false,
            white_nits: 203.0,
            peak_nits: 1000.0,
        }
    }
}

impl SkyUniform {
    /// From a frame, the axes of its local frame in the world (level toward the sun, left of it, up)
    /// and the display. `baked_scale` \[m²·cd⁻¹\] brings the frame's light near 1.
    #[must_use]
    pub fn new(
        picture: &Picture,
        [local_x, local_y, local_z]: [[f32; 3]; 3],
        display: DisplaySettings,
        baked_scale: f32,
    ) -> Self {
        let radii = picture.sky.radii();
        let sun = &picture.sun;
        Self {
            coefficients: *picture.sky.coefficients(),
            radii: radii.in_scale_heights,
            radii_roots: radii.half_roots,
            sun_sin_cos: picture.sky.sun(),
            cos_horizon: picture.sky.cos_horizon(),
            cos_lowest: picture.sky.cos_lowest(),
            local_x,
            altitude_km: picture.altitude_km,
            local_y,
            sin_sun_radius: sun.sin_radius,
            local_z,
            outside_domain: 0.0,
            sun_upper: sun.upper,
            sun_upper_cosine: sun.cosines[0],
            sun_lower: sun.lower,
            sun_lower_cosine: sun.cosines[1],
            ground: picture.light.ground,
            baked_scale,
            exposure: display.exposure,
            scene_exposure: display.scene_exposure,
            largest: display.largest,
            tone: display.tone,
            dither_step: display.dither_step,
            target_encodes: f32::from(u8::from(display.target_encodes)),
            white_nits: display.white_nits,
            peak_nits: display.peak_nits,
        }
    }
}

impl AerialUniform {
    /// From the frame.
    #[must_use]
    pub fn new(air: &AerialFrame) -> Self {
        let mut coefficients = [[0.0; 4]; TERMS * MAX_LAYERS];
        for (to, from) in coefficients
            .iter_mut()
            .zip(air.coefficients.iter().flatten())
        {
            *to = *from;
        }
        let mut node_altitudes_km = [[0.0; 4]; MAX_LAYERS / 4];
        let places = node_altitudes_km.iter_mut().flatten();
        for (to, from) in places.zip(air.altitude_km) {
            *to = from;
        }
        let [air_per_km, gas_per_km, haze_per_km, stratosphere_per_km] = air.per_km;
        let [red_weights, green_weights, blue_weights, luminance_weights] = air.weights;
        Self {
            coefficients,
            node_altitudes_km,
            air_per_km,
            gas_per_km,
            haze_per_km,
            stratosphere_per_km,
            red_weights,
            green_weights,
            blue_weights,
            luminance_weights,
            levels: air.levels,
            sun_sin_cos: air.sun,
            node_count: u16::try_from(air.layers).map_or(0.0, f32::from),
            haze_per_scale_height: air.haze_per_scale_height,
            rise_ends: SECTIONS.into(),
            path_ends: f32::from(SECTIONS) + 3.0,
            unused: [0.0; 2],
        }
    }
}

/// Constants, structs and the three variables as WGSL: binding 0 of the bind group is `sky`, 1
/// `aerial`, 2 `view`.
#[must_use]
pub fn wgsl(group: u32) -> String {
    declarations() + "\n" + &bindings(group, &["sky", "aerial", "view"])
}

/// The constants and structs as WGSL.
#[must_use]
pub fn declarations() -> String {
    let mut out = String::from("// Made from the tables in crates/sky-core/src/uniforms.rs.\n\n");
    for constant in CONSTANTS {
        let Constant { name, meaning, .. } = constant;
        // writing to a string cannot fail
        let _ = match constant.value {
            Value::Float(value) => writeln!(out, "// {meaning}\nconst {name}: f32 = {value:?};"),
            Value::Count(value) => writeln!(out, "// {meaning}\nconst {name}: u32 = {value}u;"),
        };
    }
    for (name, members) in [
        ("SkyUniform", SkyUniform::MEMBERS),
        ("AerialUniform", AerialUniform::MEMBERS),
        ("ViewUniform", ViewUniform::MEMBERS),
    ] {
        let _ = writeln!(out, "\nstruct {name} {{");
        for member in members {
            let Member {
                name,
                kind,
                offset,
                unit,
                meaning,
                ..
            } = member;
            let _ = writeln!(
                out,
                "    // {offset}: {meaning} [{unit}]\n    {name}: {kind},"
            );
        }
        out.push_str("}\n");
    }
    out
}

/// The variables of some names (`sky`, `aerial`, `view`) as WGSL, in a bind group of the caller's
/// choice.
#[must_use]
pub fn bindings(group: u32, names: &[&str]) -> String {
    [
        ("sky", "SkyUniform"),
        ("aerial", "AerialUniform"),
        ("view", "ViewUniform"),
    ]
    .into_iter()
    .enumerate()
    .filter(|(_, (name, _))| names.contains(name))
    .map(|(binding, (name, of))| {
        format!("@group({group}) @binding({binding}) var<uniform> {name}: {of};\n")
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_the_members_numbers_in_order() {
        let mut uniform = ViewUniform::default();
        uniform.clip_to_world[3][2] = 1.0;
        uniform.ray_x = [2.0, 3.0, 4.0];
        uniform.projection = 5.0;
        uniform.rays_are_parallel = 6.0;
        let bytes = uniform.as_bytes();
        let at = |offset: usize| {
            f32::from_ne_bytes([
                bytes[offset],
                bytes[offset + 1],
                bytes[offset + 2],
                bytes[offset + 3],
            ])
        };
        for member in ViewUniform::MEMBERS {
            let expected: &[f32] = match member.name {
                "clip_to_world" => &[0.0, 0.0],
                "ray_x" => &[2.0, 3.0, 4.0],
                "projection" => &[5.0],
                "rays_are_parallel" => &[6.0],
                _ => &[0.0],
            };
            for (i, expected) in expected.iter().enumerate() {
                let found = at(member.offset + 4 * i);
                assert!((found - expected).abs() < 1e-9, "{}: {found}", member.name);
            }
        }
        assert!((at(4 * 14) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_published_text_is_the_one_that_the_tables_make() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders/uniforms.wgsl");
        let published = std::fs::read_to_string(path).expect("the file");
        assert_eq!(
            published,
            wgsl(0),
            "shaders/uniforms.wgsl is not what uniforms.rs makes"
        );
    }

    #[test]
    fn members_out_of_place_are_seen() {
        let [a, b] = [SkyUniform::MEMBERS[1], SkyUniform::MEMBERS[6]];
        assert!(!is_laid_out(&[a], a.bytes), "does not begin at 0");
        let b = Member { offset: 0, ..b };
        assert!(
            !is_laid_out(&[b], b.bytes),
            "12 bytes are no multiple of 16"
        );
    }
}
