// The terrain as seen from the camera: light in cd/m2 before the air, and reversed depth. East, north
// and up from the camera; kilometers in, meters out.

struct SceneUniform {
    // from the world [m], the camera at its origin, to clip space
    clip_from_world: mat4x4<f32>,
    // toward the sun; w: the camera's altitude [km]
    sun: vec4<f32>,
    // on a plane facing the sun, and of the sky on a horizontal plane [lx]
    sun_light: vec4<f32>,
    sky_light: vec4<f32>,
}

struct SquareUniform {
    // east and north of the camera, side of a cell [km], 0
    place: vec4<f32>,
}

@group(0) @binding(0) var<uniform> scene: SceneUniform;
@group(0) @binding(1) var<uniform> square: SquareUniform;

const EARTH_RADIUS_KM: f32 = 6371.0;
const CORNERS: u32 = 193u;

struct GroundVertex {
    @builtin(position) position: vec4<f32>,
    // height [km], slopes toward east and north
    @location(0) ground: vec3<f32>,
}

@vertex
fn ground_vertex(@builtin(vertex_index) index: u32, @location(0) ground: vec3<f32>) -> GroundVertex {
    let cell = vec2<f32>(f32(index % CORNERS), f32(index / CORNERS)) - 96.0;
    let flat = square.place.xy + cell * square.place.z;
    // over the Earth: the angle at its center is small, so its series are short and exact
    let square_angle = dot(flat, flat) / (EARTH_RADIUS_KM * EARTH_RADIUS_KM);
    let radius = EARTH_RADIUS_KM + ground.x;
    let sine_over_angle = 1.0 - square_angle / 6.0 * (1.0 - square_angle / 20.0);
    let one_less_cosine = square_angle * (0.5 - square_angle / 24.0 * (1.0 - square_angle / 30.0));
    let up = ground.x - scene.sun.w - radius * one_less_cosine;
    let across = flat * (radius / EARTH_RADIUS_KM * sine_over_angle);
    var out: GroundVertex;
    out.position = scene.clip_from_world * vec4<f32>(1000.0 * across, 1000.0 * up, 1.0);
    out.ground = ground;
    return out;
}

// Twin: `shade` in terrain.rs.
@fragment
fn ground_fragment(in: GroundVertex) -> @location(0) vec4<f32> {
    let normal = normalize(vec3<f32>(-in.ground.y, -in.ground.z, 1.0));
    let snow = clamp((in.ground.x - 2.0) * 2.0, 0.0, 1.0) * pow(normal.z, 4.0);
    let forest = vec3<f32>(0.05, 0.09, 0.035);
    let rock = vec3<f32>(0.20, 0.18, 0.15);
    let bare = clamp(1.0 - normal.z, 0.0, 0.4) * 2.5;
    let ground = mix(forest, rock, bare);
    let albedo = mix(ground, vec3<f32>(0.75, 0.75, 0.75), snow);
    let open = 0.5 + 0.5 * normal.z;
    let lit = scene.sun_light.xyz * max(dot(normal, scene.sun.xyz), 0.0) + scene.sky_light.xyz * open;
    return vec4<f32>(albedo * lit / 3.14159265, 1.0);
}
