// Made from the tables in crates/sky-core/src/uniforms.rs.

// radius of the Earth [km]
const EARTH_RADIUS_KM: f32 = 6371.0;
// scale height of the air in the formula's air mass [km]
const AIR_SCALE_HEIGHT_KM: f32 = 8.0;
// scale height of the haze in the formula's air mass [km]
const HAZE_SCALE_HEIGHT_KM: f32 = 1.2;
// products of the formula
const TERMS: u32 = 22u;
// width, in the cosine, of the bend to the lowest fitted ring
const LOWEST_RING_BEND: f32 = 0.0014;
// how far below the horizon, in the cosine, a direction still counts as sky
const HORIZON_SLACK: f32 = 2e-7;
// how much darker than its center the limb of the sun is
const LIMB_DARKENING: f32 = 0.6;
// share of an HDR display's peak above which highlights roll off
const SHOULDER: f32 = 0.75;
// what scRGB shows a 1 with [cd/m2]
const SCRGB_UNIT_NITS: f32 = 80.0;
// levels of the air's density
const LEVELS: u32 = 31u;
// distance of the levels [km]
const LEVEL_STEP_KM: f32 = 2.0;
// altitude of the highest level [km]
const TOP_OF_AIR_KM: f32 = 60.0;
// sections of a path, descent and rise each
const SECTIONS: f32 = 4.0;
// light scattered before, as a share of that scattered once, in clear air
const SCATTERED_BEFORE: f32 = 0.3;
// texels of a baked sky across
const BAKED_WIDTH: f32 = 160.0;
// texels of a baked sky up
const BAKED_HEIGHT: f32 = 192.0;
// of these the lowest for the ground
const BAKED_GROUND: f32 = 40.0;
// rings of the dome below the horizon
const GROUND_RINGS: u32 = 6u;

struct SkyUniform {
    // 0: of ln Y, x and y for each product of the formula; the fourth place is not read [1]
    coefficients: array<vec4<f32>, 22>,
    // 352: distance from the Earth's center in scale heights of air and of haze [1]
    radii: vec2<f32>,
    // 360: square roots of half of these [1]
    radii_roots: vec2<f32>,
    // 368: sine and cosine of the sun's zenith angle [1]
    sun_sin_cos: vec2<f32>,
    // 376: cosine of the geometric horizon's zenith angle [1]
    cos_horizon: f32,
    // 380: cosine of the zenith angle of the lowest ring that the table was fitted to [1]
    cos_lowest: f32,
    // 384: the world's direction level toward the sun's azimuth [1]
    local_x: vec3<f32>,
    // 396: the observer's altitude [km]
    altitude_km: f32,
    // 400: the world's direction level, left of the sun [1]
    local_y: vec3<f32>,
    // 412: sine of the sun's angular radius [1]
    sin_sun_radius: f32,
    // 416: the world's direction up at the observer [1]
    local_z: vec3<f32>,
    // 428: paints stripes in place of the sky [flag]
    outside_domain: f32,
    // 432: light of the disc's center through the air at its upper limb, linear sRGB [cd·m⁻²]
    sun_upper: vec3<f32>,
    // 444: cosine of the upper limb's zenith angle [1]
    sun_upper_cosine: f32,
    // 448: the same at its lower limb, or at the horizon [cd·m⁻²]
    sun_lower: vec3<f32>,
    // 460: cosine of the lower limb's zenith angle [1]
    sun_lower_cosine: f32,
    // 464: light of the ground, linear sRGB [cd·m⁻²]
    ground: vec3<f32>,
    // 476: brings light into the range of the baked sky's half floats [m²·cd⁻¹]
    baked_scale: f32,
    // 480: multiplies light before it is displayed [m²·cd⁻¹]
    exposure: f32,
    // 484: what the colors of a finished scene were multiplied with [m²·cd⁻¹]
    scene_exposure: f32,
    // 488: largest number that a target of linear light holds [1]
    largest: f32,
    // 492: the tone curve of a display: 0 none, 1 Reinhard, 2 ACES, 3 neutral [1]
    tone: f32,
    // 496: distance of two levels of the target, 0 for no noise [1]
    dither_step: f32,
    // 500: the target encodes sRGB by itself [flag]
    target_encodes: f32,
    // 504: what an HDR display shows an exposed 1 with [cd·m⁻²]
    white_nits: f32,
    // 508: the brightest that an HDR display shows [cd·m⁻²]
    peak_nits: f32,
}

struct AerialUniform {
    // 0: of ln Y, x and y for each product, altitude node by altitude node [1]
    coefficients: array<vec4<f32>, 352>,
    // 5632: altitudes of the nodes, four a vector [km]
    node_altitudes_km: array<vec4<f32>, 4>,
    // 5696: scattering coefficient of the air at the ground, at four wavelengths [km⁻¹]
    air_per_km: vec4<f32>,
    // 5712: absorption coefficient of the gases where they are densest [km⁻¹]
    gas_per_km: vec4<f32>,
    // 5728: extinction coefficient of the haze at the ground [km⁻¹]
    haze_per_km: vec4<f32>,
    // 5744: extinction coefficient of the stratospheric aerosol where it is densest [km⁻¹]
    stratosphere_per_km: vec4<f32>,
    // 5760: shares of the wavelengths in red [1]
    red_weights: vec4<f32>,
    // 5776: shares of the wavelengths in green [1]
    green_weights: vec4<f32>,
    // 5792: shares of the wavelengths in blue [1]
    blue_weights: vec4<f32>,
    // 5808: shares of the wavelengths in luminance [1]
    luminance_weights: vec4<f32>,
    // 5824: logarithm of the air's relative density, relative densities of gas and stratospheric aerosol, 0 [1]
    levels: array<vec4<f32>, 31>,
    // 6320: sine and cosine of the sun's zenith angle [1]
    sun_sin_cos: vec2<f32>,
    // 6328: altitude nodes in use, at least 2 [1]
    node_count: f32,
    // 6332: one over the scale height of the haze [km⁻¹]
    haze_per_scale_height: f32,
    // 6336: ends of the sections of a rise: a bound that drivers cannot unroll, SECTIONS [1]
    rise_ends: f32,
    // 6340: ends of the sections of a path, SECTIONS and 3 [1]
    path_ends: f32,
    // 6344: 0 [1]
    unused: vec2<f32>,
}

struct ViewUniform {
    // 0: from clip space (x, y, depth, 1) to world directions, translation left out; of a panorama from right, forward and up [1]
    clip_to_world: mat4x4<f32>,
    // 64: its inverse [1]
    world_to_clip: mat4x4<f32>,
    // 128: world direction of a ray: ray_x times clip x [1]
    ray_x: vec3<f32>,
    // 140: 0 a matrix, 1 fisheye, 2 equirectangular [1]
    projection: f32,
    // 144: and ray_y times clip y [1]
    ray_y: vec3<f32>,
    // 156: width over height of a fisheye picture [1]
    aspect: f32,
    // 160: and ray_center [1]
    ray_center: vec3<f32>,
    // 172: depth in clip space of what is infinitely far [1]
    far_depth: f32,
    // 176: first pixel of the viewport [pixel]
    viewport_origin: vec2<f32>,
    // 184: length of a unit of the world [km]
    km_per_unit: f32,
    // 188: a scene's depth is a distance in km, 0 for the sky [flag]
    depth_is_distance: f32,
    // 192: rings of the dome from the zenith to the horizon [1]
    dome_rings: f32,
    // 196: corners of a ring [1]
    dome_spokes: f32,
    // 200: azimuth from the sun where the dome is cut [rad]
    dome_seam_azimuth: f32,
    // 204: the projection is orthographic [flag]
    rays_are_parallel: f32,
}

@group(0) @binding(0) var<uniform> sky: SkyUniform;
@group(0) @binding(1) var<uniform> aerial: AerialUniform;
@group(0) @binding(2) var<uniform> view: ViewUniform;
