//! Every shader translates to every language that it is offered in.

use clap::ValueEnum as _;
use sky_cli::commands::export_shaders::ShaderTarget;
use sky_cli::commands::export_shaders::translate;
use sky_gpu::{Output, shader};

#[test]
fn every_program_translates_to_every_language() {
    for program in shader::PROGRAMS {
        let name = program.name;
        for output in Output::ALL {
            let text = shader::text(program, output);
            for target in ShaderTarget::value_variants() {
                if *target == ShaderTarget::GlslEs && !program.in_glsl_es {
                    continue;
                }
                let files = translate(name, &text, *target)
                    .unwrap_or_else(|error| panic!("{name} to {target:?}: {error:#}"));
                let written = files.iter().all(|(_, bytes)| bytes.len() > 100);
                assert!(written && !files.is_empty(), "{name} to {target:?}");
            }
        }
    }
}

#[test]
fn perez_s_formula_translates_too() {
    let text = format!(
        "{}\n@fragment fn f(@location(0) v: vec4<f32>) -> @location(0) vec4<f32> {{ return \
         vec4<f32>(perez(v, v.x, v.y, v.z)); }}",
        shader::PEREZ.1
    );
    for target in ShaderTarget::value_variants() {
        translate("perez", &text, *target).unwrap_or_else(|error| panic!("{target:?}: {error:#}"));
    }
}
