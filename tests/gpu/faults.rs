//! What once was drawn wrong, each test named after its fault; and what a renderer is asked for: depth,
//! outputs, conditions outside the domain. Needs a Vulkan driver; a software one will do.

use std::sync::LazyLock;

use glam::{Mat3, Mat4, Vec3, Vec4};
use sky_core::hdr::{hdr10, scrgb};
use sky_core::picture::Picture;
use sky_core::quantity::Length;
use sky_core::utm_sky::UtmSky;
use sky_gpu::headless::Headless;
use sky_gpu::{
    Camera, Exposure, FrameSettings, Haze, Output, Projection, SkyRenderer, SkyRendererOptions,
    Tier, View, sky_depth,
};

static GPU: LazyLock<Headless> =
    LazyLock::new(|| Headless::new().unwrap_or_else(|error| panic!("{error}")));
static SKY: LazyLock<UtmSky> = LazyLock::new(|| UtmSky::embedded().expect("the table"));

const FLOATS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const SIZE: [u32; 2] = [32, 24];

/// Looks north, level.
fn camera() -> Camera {
    let looking = Mat3::from_cols(Vec3::X, Vec3::Z, -Vec3::Y).transpose();
    Camera::perspective(0.8, 4.0 / 3.0, looking)
}

fn frame() -> FrameSettings {
    FrameSettings {
        observer_altitude: Length::from_km(2.0),
        sun: Vec3::new(0.8, -0.3, 0.5),
        exposure: Exposure::None,
        ..FrameSettings::default()
    }
}

fn picture(frame: &FrameSettings) -> Picture {
    let conditions = frame.conditions().expect("a haze");
    Picture::new(&SKY, &conditions, frame.ground_albedo).expect("inside the domain")
}

/// The direction of a pixel's center in the frame's local frame.
fn local(camera: &Camera, frame: &FrameSettings, i: usize) -> [f32; 3] {
    let [x, y] = [i % SIZE[0] as usize, i / SIZE[0] as usize].map(|p| p as f32 + 0.5);
    let clip = [
        2.0 * x / SIZE[0] as f32 - 1.0,
        1.0 - 2.0 * y / SIZE[1] as f32,
    ];
    let seen = camera.direction(clip).expect("a direction");
    frame.local_axes().map(|axis| axis.dot(seen))
}

fn options(format: wgpu::TextureFormat, output: Output) -> SkyRendererOptions {
    SkyRendererOptions::new(format, output)
}

/// A renderer and a view of the frame that is ready to be drawn.
fn ready(
    options: &SkyRendererOptions,
    frame: &FrameSettings,
    camera: &Camera,
) -> (SkyRenderer, View) {
    let renderer = SkyRenderer::new(&GPU.device, &SKY, options);
    let mut view = renderer.view(&GPU.device);
    renderer
        .update(&GPU.queue, &mut view, frame)
        .expect("inside the domain");
    renderer.set_camera(&GPU.queue, &mut view, camera);
    let mut encoder = GPU.device.create_command_encoder(&Default::default());
    renderer.prepare(&GPU.queue, &mut encoder, &mut view, Tier::Fragment);
    GPU.queue.submit([encoder.finish()]);
    (renderer, view)
}

fn texture(format: wgpu::TextureFormat, sample_count: u32) -> wgpu::Texture {
    let copied = if sample_count == 1 && format != DEPTH {
        wgpu::TextureUsages::COPY_SRC
    } else {
        wgpu::TextureUsages::empty()
    };
    GPU.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: SIZE[0],
            height: SIZE[1],
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | copied,
        view_formats: &[],
    })
}

/// Draws in a pass that begins with a depth, where one is given.
fn drawn(
    target: &wgpu::Texture,
    depth: Option<f32>,
    draw: impl FnOnce(&mut wgpu::RenderPass<'_>),
) -> Vec<u8> {
    let mut encoder = GPU.device.create_command_encoder(&Default::default());
    let depth_view = texture(DEPTH, 1).create_view(&Default::default());
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &target.create_view(&Default::default()),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: depth.map(|depth| wgpu::RenderPassDepthStencilAttachment {
            view: &depth_view,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(depth),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    draw(&mut pass);
    drop(pass);
    GPU.queue.submit([encoder.finish()]);
    GPU.read(target).expect("pixels")
}

fn floats(bytes: &[u8]) -> Vec<[f32; 3]> {
    bytes
        .chunks_exact(16)
        .map(|p| [0, 4, 8].map(|c| f32::from_le_bytes([p[c], p[c + 1], p[c + 2], p[c + 3]])))
        .collect()
}

#[test]
fn a18_an_orthographic_camera_sees_one_direction() {
    let (near, far, half) = (0.1, 5e4, 2000.0);
    let camera = Camera {
        projection: Projection::Matrix {
            clip_from_view: Mat4::from_cols(
                Vec4::new(1.0 / half, 0.0, 0.0, 0.0),
                Vec4::new(0.0, 1.0 / half, 0.0, 0.0),
                Vec4::new(0.0, 0.0, 1.0 / (near - far), 0.0),
                Vec4::new(0.0, 0.0, near / (near - far), 1.0),
            ),
            far_depth: 1.0,
        },
        ..camera()
    };
    let frame = frame();
    let expected = picture(&frame).color(local(&camera, &frame, 0));
    for tier in [
        Tier::Fragment,
        Tier::Baked,
        Tier::Vertex(sky_gpu::Dome::REPORT),
    ] {
        let (renderer, mut view) = ready(&options(FLOATS, Output::Linear), &frame, &camera);
        let mut encoder = GPU.device.create_command_encoder(&Default::default());
        renderer.prepare(&GPU.queue, &mut encoder, &mut view, tier);
        GPU.queue.submit([encoder.finish()]);
        let pixels = drawn(&texture(FLOATS, 1), None, |pass| renderer.draw(pass, &view));
        for found in floats(&pixels) {
            for c in 0..3 {
                let off = (found[c] / expected[c] - 1.0).abs();
                assert!(off < 0.01, "{tier:?}: {found:?}, evaluator {expected:?}");
            }
        }
    }
}

/// Before the scene and after it: the sky is where the depth is still the far one.
#[test]
fn the_sky_is_drawn_at_the_far_depth_reversed_and_forward() {
    for (reversed, far, near) in [(true, 0.0, 1.0), (false, 1.0, 0.0)] {
        let camera = Camera {
            projection: match camera().projection {
                Projection::Matrix { clip_from_view, .. } if reversed => Projection::Matrix {
                    clip_from_view,
                    far_depth: 0.0,
                },
                Projection::Matrix { clip_from_view, .. } => Projection::Matrix {
                    // the same rays, depth turned round
                    clip_from_view: Mat4::from_cols(
                        Vec4::X,
                        Vec4::Y,
                        Vec4::NEG_Z,
                        Vec4::new(0.0, 0.0, 1.0, 1.0),
                    ) * clip_from_view,
                    far_depth: 1.0,
                },
                other => other,
            },
            ..camera()
        };
        let options = SkyRendererOptions {
            depth_stencil: Some(sky_depth(DEPTH, reversed)),
            ..options(FLOATS, Output::Linear)
        };
        for tier in [
            Tier::Fragment,
            Tier::Baked,
            Tier::Vertex(sky_gpu::Dome::FINE),
        ] {
            let frame = frame();
            let (renderer, mut view) = ready(&options, &frame, &camera);
            let mut encoder = GPU.device.create_command_encoder(&Default::default());
            renderer.prepare(&GPU.queue, &mut encoder, &mut view, tier);
            GPU.queue.submit([encoder.finish()]);
            let target = texture(FLOATS, 1);
            let shown = |depth| {
                let bytes = drawn(&target, Some(depth), |pass| renderer.draw(pass, &view));
                floats(&bytes)
            };
            let hidden = 0.5 * (far + near);
            assert!(
                shown(hidden).iter().flatten().all(|c| c.abs() <= 0.0),
                "{tier:?}, reversed {reversed}: drawn over an object"
            );
            for (i, found) in shown(far).into_iter().enumerate() {
                let expected = picture(&frame).color(local(&camera, &frame, i));
                let off = (found[1] / expected[1] - 1.0).abs();
                assert!(
                    off < 0.06,
                    "{tier:?} {i}: {found:?}, evaluator {expected:?}"
                );
            }
        }
    }
}

#[test]
fn hdr_outputs_are_their_twins() {
    let frame = FrameSettings {
        exposure: Exposure::Scale(3e-4),
        ..frame()
    };
    let (white_nits, peak_nits) = (203.0, 600.0);
    let camera = camera();
    let picture = picture(&frame);
    let exposed = |i| {
        picture
            .color(local(&camera, &frame, i))
            .map(|light| light * 3e-4)
    };

    let format = wgpu::TextureFormat::Rgb10a2Unorm;
    let output = Output::Hdr10 {
        white_nits,
        peak_nits,
    };
    let (renderer, view) = ready(&options(format, output), &frame, &camera);
    let bytes = drawn(&texture(format, 1), None, |pass| renderer.draw(pass, &view));
    for (i, p) in bytes.chunks_exact(4).enumerate() {
        let texel = u32::from_le_bytes([p[0], p[1], p[2], p[3]]);
        let expected = hdr10(exposed(i), white_nits, peak_nits);
        for (c, expected) in expected.into_iter().enumerate() {
            let level = (texel >> (10 * c) & 1023) as f32;
            // half a level of rounding, one of noise, and the drivers' pow
            let off = (level - 1023.0 * expected).abs();
            assert!(
                off <= 2.0,
                "{i} {c}: level {level}, twin {}",
                1023.0 * expected
            );
        }
    }

    let output = Output::ScRgb {
        white_nits,
        peak_nits,
    };
    let (renderer, view) = ready(&options(FLOATS, output), &frame, &camera);
    let bytes = drawn(&texture(FLOATS, 1), None, |pass| renderer.draw(pass, &view));
    for (i, found) in floats(&bytes).into_iter().enumerate() {
        let expected = scrgb(exposed(i), white_nits, peak_nits);
        for c in 0..3 {
            let off = (found[c] - expected[c]).abs();
            assert!(
                off <= 2e-3 * expected[c].abs().max(0.1),
                "{i}: {found:?}, twin {expected:?}"
            );
        }
    }
}

#[test]
fn outside_the_domain_the_nearest_sky_is_shown_and_said_so() {
    let (renderer, mut view) = ready(&options(FLOATS, Output::Linear), &frame(), &camera());
    let mut show = |altitude_km: f64, turbidity: f64| {
        let asked = FrameSettings {
            observer_altitude: Length::from_km(altitude_km),
            haze: Haze::Turbidity(turbidity),
            ..frame()
        };
        assert_eq!(
            renderer.update(&GPU.queue, &mut view, &asked).is_ok(),
            (0.0..=30.0).contains(&altitude_km) && turbidity <= 8.0
        );
        renderer
            .update_nearest(&GPU.queue, &mut view, &asked)
            .map(|(_, nearest)| {
                (
                    nearest.changes().next().is_some(),
                    nearest.conditions.observer_altitude.km(),
                    nearest.conditions.turbidity,
                )
            })
    };
    assert_eq!(show(2.0, 2.5), Ok((false, 2.0, 2.5)));
    assert_eq!(show(35.0, 2.5), Ok((true, 30.0, 2.5)));
    assert_eq!(show(-0.4, 9.0), Ok((true, 0.0, 8.0)));
    assert!(show(f64::NAN, 2.5).is_err());
}

/// A wall 20 km away that covers the left half and a little, drawn with four samples.
const WALL: &str = "
@vertex
fn wall_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32(index & 1u), f32(index >> 1u));
    return vec4<f32>(-1.0 + 1.03 * corner.x + 0.2 * corner.x * corner.y, 2.0 * corner.y - 1.0, 5e-6, 1.0);
}
@fragment
fn wall_fragment() -> @location(0) vec4<f32> {
    return vec4<f32>(8.0, 6.0, 4.0, 1.0);
}
";

/// Draws the wall into a resolved color and a multisampled depth.
fn wall() -> (wgpu::Texture, wgpu::Texture) {
    let format = wgpu::TextureFormat::Rgba16Float;
    let device = &GPU.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(WALL.into()),
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState {
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            depth_write_enabled: Some(true),
            ..sky_depth(DEPTH, true)
        }),
        multisample: wgpu::MultisampleState {
            count: 4,
            ..Default::default()
        },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let (color, samples, depth) = (texture(format, 1), texture(format, 4), texture(DEPTH, 4));
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &samples.create_view(&Default::default()),
            depth_slice: None,
            resolve_target: Some(&color.create_view(&Default::default())),
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Discard,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth.create_view(&Default::default()),
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0.0),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.draw(0..4, 0..1);
    drop(pass);
    GPU.queue.submit([encoder.finish()]);
    (color, depth)
}

/// With the scene's pre-exposure taken off: inside the wall its light behind the air, outside the sky,
/// at the edge a share of both.
#[test]
fn a_multisampled_depth_is_composited_without_a_seam() {
    let frame = FrameSettings {
        scene_exposure: 0.01,
        ..frame()
    };
    let options = SkyRendererOptions {
        scene_depth_multisampled: true,
        ..options(FLOATS, Output::Linear)
    };
    let camera = camera();
    let (renderer, view) = ready(&options, &frame, &camera);
    let (color, depth) = wall();
    let scene = renderer.scene(
        &GPU.device,
        &color.create_view(&Default::default()),
        &depth.create_view(&Default::default()),
    );
    let bytes = drawn(&texture(FLOATS, 1), None, |pass| {
        renderer.draw(pass, &view);
        renderer.composite(pass, &view, &scene, true);
    });
    let picture = picture(&frame);
    let Projection::Matrix { clip_from_view, .. } = camera.projection else {
        panic!("a matrix");
    };
    let mut seen = [0; 3];
    for (i, found) in floats(&bytes).into_iter().enumerate() {
        let direction = local(&camera, &frame, i);
        let [x, y] = [i % SIZE[0] as usize, i / SIZE[0] as usize].map(|p| p as f32 + 0.5);
        let clip = [
            2.0 * x / SIZE[0] as f32 - 1.0,
            1.0 - 2.0 * y / SIZE[1] as f32,
        ];
        // the distance of the wall's depth along the ray
        let place = clip_from_view.inverse() * Vec4::new(clip[0], clip[1], 5e-6, 1.0);
        let distance_km = (place.truncate() / place.w).length() / 1000.0;
        let object = picture.behind_air(direction, distance_km, [800.0, 600.0, 400.0]);
        let sky = picture.color(direction);
        let edge = 0.03 + 0.2 * (0.5 + 0.5 * clip[1]);
        let pixel = 2.0 / SIZE[0] as f32;
        let (low, high) = match () {
            () if clip[0] < edge - 1.5 * pixel => (object, object),
            () if clip[0] > edge + 1.5 * pixel => (sky, sky),
            () => (
                core::array::from_fn(|c| object[c].min(sky[c])),
                core::array::from_fn(|c| object[c].max(sky[c])),
            ),
        };
        seen[usize::from(clip[0] >= edge - 1.5 * pixel)
            + usize::from(clip[0] > edge + 1.5 * pixel)] += 1;
        for c in 0..3 {
            let slack = 4e-3 * high[c].abs();
            assert!(
                found[c] >= low[c] - slack && found[c] <= high[c] + slack,
                "{i}: {found:?}, object {object:?}, sky {sky:?}"
            );
        }
    }
    assert!(seen.iter().all(|n| *n > 40), "{seen:?}");
}
