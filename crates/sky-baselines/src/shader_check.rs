//! For tests: is a shader valid, and does it fit the portable subset?

use naga::valid::{Capabilities, ValidationFlags, Validator};
use sky_core::conditions::Conditions;
use sky_core::quantity::{Angle, Length};
use sky_science::shader_sky::{SHADER_HEADER, SHADER_UNIFORMS, ShaderSky};

pub(crate) fn conditions(altitude_km: f64, turbidity: f64, sun_deg: f64) -> Conditions {
    Conditions {
        observer_altitude: Length::from_km(altitude_km),
        turbidity,
        sun_zenith: Angle::from_degrees(sun_deg),
    }
}

const ENTRY: &str = "
@fragment
fn shade(@location(0) direction: vec3<f32>) -> @location(0) vec4<f32> {
    return vec4<f32>(baseline_xyz(normalize(direction)), 1.0);
}
";

/// Parses and validates header and shader without any optional capability, translates both to
/// GLSL ES 3.00, and checks the frame's sizes and range.
pub(crate) fn check(sky: &dyn ShaderSky, conditions: &Conditions) {
    let text = format!("{SHADER_HEADER}{}{ENTRY}", sky.shader());
    let module = naga::front::wgsl::parse_str(&text)
        .unwrap_or_else(|e| panic!("{}: {}", sky.name(), e.emit_to_string(&text)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}: {e:?}", sky.name()));
    let options = naga::back::glsl::Options {
        version: naga::back::glsl::Version::new_gles(300),
        ..naga::back::glsl::Options::default()
    };
    let pipeline = naga::back::glsl::PipelineOptions {
        shader_stage: naga::ShaderStage::Fragment,
        entry_point: "shade".to_owned(),
        multiview: None,
    };
    let mut glsl = String::new();
    naga::back::glsl::Writer::new(
        &mut glsl,
        &module,
        &info,
        &options,
        &pipeline,
        naga::proc::BoundsCheckPolicies::default(),
    )
    .unwrap_or_else(|e| panic!("{}: {e}", sky.name()))
    .write()
    .unwrap_or_else(|e| panic!("{}: {e}", sky.name()));
    assert!(glsl.starts_with("#version 300 es"), "{glsl}");

    let frame = sky.shader_frame(conditions).expect("inside the domain");
    assert!(frame.uniforms.len() <= SHADER_UNIFORMS);
    assert!(frame.uniforms.iter().flatten().all(|v| v.is_finite()));
    if let Some(texture) = frame.texture {
        let texels = usize::try_from(texture.width * texture.height).expect("small");
        assert_eq!(texture.texels.len(), texels);
        assert!(texture.width <= 2048 && texture.height <= 2048);
        let f16 = 65504.0;
        assert!(texture.texels.iter().flatten().all(|v| v.abs() <= f16));
    }
}
