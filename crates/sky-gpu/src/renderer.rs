//! The renderer: it draws the skies of views.

use sky_core::conditions::{Conditions, Nearest};
use sky_core::picture::Picture;
use sky_core::tonemap::luminance;
use sky_core::uniforms::{BAKED_GROUND, BAKED_SIZE, DisplaySettings, SkyUniform};
use sky_core::utm_sky::UtmSky;

use crate::camera::Camera;
use crate::frame::{FrameError, FrameSettings, mean};
use crate::layouts::Layouts;
use crate::options::{SkyRendererOptions, dither_step, largest};
use crate::pipelines::Pipelines;
use crate::tier::Tier;
use crate::view::View;

/// Luminance that the baked sky's mean is scaled to: far from both ends of a half float.
const BAKED_MEAN: f32 = 16.0;

/// Draws the sky of a table for any number of [`View`]s.
///
/// It is made once for a device and a kind of target. Every frame: [`Self::update`] and
/// [`Self::set_camera`] for each view, [`Self::prepare`] before the pass, [`Self::draw`] in it, and
/// where a finished scene lies in textures [`Self::composite`].
#[derive(Debug)]
pub struct SkyRenderer {
    sky: UtmSky,
    options: SkyRendererOptions,
    layouts: Layouts,
    pipelines: Pipelines,
}

/// Where render-pass timestamps are written.
#[derive(Clone, Copy, Debug)]
pub struct Timing<'a> {
    /// The queries.
    pub queries: &'a wgpu::QuerySet,
    /// Place of the first of two.
    pub first: u32,
}

impl SkyRenderer {
    /// A renderer for a table and a kind of target.
    ///
    /// What wgpu refuses (a format that cannot be drawn to, a sample count that the device lacks) it
    /// refuses in its own way, by the device's error handler.
    #[must_use]
    pub fn new(device: &wgpu::Device, sky: &UtmSky, options: &SkyRendererOptions) -> Self {
        let layouts = Layouts::new(device, options);
        Self {
            sky: sky.clone(),
            options: options.clone(),
            pipelines: Pipelines::new(device, &layouts, options),
            layouts,
        }
    }

    /// A view of its own: an observer and a camera. 247 KiB on the device.
    #[must_use]
    pub fn view(&self, device: &wgpu::Device) -> View {
        View::new(device, &self.layouts)
    }

    /// The table.
    #[must_use]
    pub const fn sky(&self) -> &UtmSky {
        &self.sky
    }

    /// Computes a view's frame and uploads it: some microseconds, no allocation of ours.
    ///
    /// # Errors
    /// When the haze cannot be or the conditions lie outside the table's domain. The view's last frame
    /// stays; [`Self::show_outside_domain`] paints stripes in its place, and
    /// [`Self::update_nearest`] the nearest sky there is.
    pub fn update<'a>(
        &self,
        queue: &wgpu::Queue,
        view: &'a mut View,
        frame: &FrameSettings,
    ) -> Result<&'a Picture, FrameError> {
        self.show(queue, view, frame, &frame.conditions()?)
    }

    /// The same, with the nearest conditions of the domain in place of those outside it: the answer says
    /// which were changed.
    ///
    /// # Errors
    /// When the haze cannot be, or a number is none.
    pub fn update_nearest<'a>(
        &self,
        queue: &wgpu::Queue,
        view: &'a mut View,
        frame: &FrameSettings,
    ) -> Result<(&'a Picture, Nearest), FrameError> {
        let nearest = self.sky.domain().nearest(&frame.conditions()?)?;
        let picture = self.show(queue, view, frame, &nearest.conditions)?;
        Ok((picture, nearest))
    }

    fn show<'a>(
        &self,
        queue: &wgpu::Queue,
        view: &'a mut View,
        frame: &FrameSettings,
        conditions: &Conditions,
    ) -> Result<&'a Picture, FrameError> {
        let mut picture = Picture::new(&self.sky, conditions, frame.ground_albedo)
            .map_err(|outside| outside.in_words_of(frame.haze))?;
        if !frame.sun_disc {
            (picture.sun.upper, picture.sun.lower) = ([0.0; 3], [0.0; 3]);
        }
        let scale = BAKED_MEAN / luminance(mean(&picture)).max(1e-6);
        let place = [
            conditions.observer_altitude.km(),
            conditions.turbidity.ln(),
            conditions.sun_zenith.radians(),
        ];
        let local = frame.local_axes();
        Ok(
            view.take(queue, picture, local, place, scale, |picture, scale| {
                let axes = local.map(|axis| axis.to_array());
                SkyUniform::new(picture, axes, self.display(frame, picture), scale)
            }),
        )
    }

    /// Paints stripes in place of a view's sky until the next update that succeeds: what lies outside
    /// the domain is never a silent wrong sky. Nothing before the first update.
    pub fn show_outside_domain(&self, queue: &wgpu::Queue, view: &mut View, frame: &FrameSettings) {
        if let Some(picture) = view.picture() {
            let axes = view.local().map(|axis| axis.to_array());
            let uniform = SkyUniform {
                outside_domain: 1.0,
                ..SkyUniform::new(picture, axes, self.display(frame, picture), 1.0)
            };
            view.take_outside(queue, &uniform);
        }
    }

    fn display(&self, frame: &FrameSettings, picture: &Picture) -> DisplaySettings {
        let [white_nits, peak_nits] = self.options.output.nits();
        DisplaySettings {
            exposure: frame.exposure(picture),
            scene_exposure: frame.scene_exposure,
            largest: largest(self.options.target_format),
            tone: frame.tone.unwrap_or_default().index(),
            dither_step: dither_step(self.options.target_format),
            target_encodes: self.options.target_format.is_srgb(),
            white_nits,
            peak_nits,
        }
    }

    /// Sets a view's camera.
    pub fn set_camera(&self, queue: &wgpu::Queue, view: &mut View, camera: &Camera) {
        view.take_camera(queue, camera);
    }

    /// Makes a view ready to be drawn by a tier: bakes what the tier takes from the texture, where it
    /// has fallen behind (the ground, and for the tier `baked` the sky). Once a frame, after update
    /// and camera, before the pass.
    pub fn prepare(
        &self,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        view: &mut View,
        tier: Tier,
    ) {
        let must_bake = view.take_tier(queue, tier);
        if must_bake == [false; 2] {
            return;
        }
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("bake the sky"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: view.baked_texture(),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Load,
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        let [width, height] = BAKED_SIZE;
        let rows = [[0, BAKED_GROUND], [BAKED_GROUND, height - BAKED_GROUND]];
        for (part, [first, count]) in rows.into_iter().enumerate() {
            if must_bake[part] {
                pass.set_pipeline(&self.pipelines.bake[part]);
                pass.set_bind_group(0, view.frame_group(), &[]);
                pass.set_scissor_rect(0, first, width, count);
                pass.draw(0..3, 0..1);
            }
        }
    }

    /// Draws a view's sky over the whole viewport, as it was prepared, at the camera's far depth:
    /// before the scene, or after it where the options have a depth test.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, view: &View) {
        let kind = usize::from(view.is_panorama());
        let (pipeline, vertices) = match view.tier() {
            Tier::Vertex(dome) => (&self.pipelines.dome, dome.vertices()),
            Tier::Fragment => (&self.pipelines.fragment[kind], 3),
            Tier::Baked => (&self.pipelines.baked[kind], 3),
        };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, view.frame_group(), &[]);
        if !matches!(view.tier(), Tier::Vertex(_)) {
            pass.set_bind_group(1, view.baked_group(), &[]);
        }
        pass.draw(0..vertices, 0..1);
    }

    /// Binds a scene's color and depth for [`Self::composite`]. The color is light \[cd·m⁻²\] times
    /// the frame's `scene_exposure`, of one sample; the depth is the texture that the scene was drawn
    /// with, or a float texture. Of a multisampled depth the color is the mean over the samples, black
    /// where the sky is.
    #[must_use]
    pub fn scene(
        &self,
        device: &wgpu::Device,
        color: &wgpu::TextureView,
        depth: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene under the sky"),
            layout: &self.layouts.scene,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(color),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::TextureView(depth),
                },
            ],
        })
    }

    /// Lays the air over a scene, pixel by pixel, and displays it; the sky's pixels are left alone.
    /// Without `air` the scene is displayed as it is. Costs as much as some twenty skies
    /// (`utm-sky bench-gpu`): where the scene's own shader can call `air_before`, it need not be used.
    pub fn composite(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        view: &View,
        scene: &wgpu::BindGroup,
        air: bool,
    ) {
        pass.set_pipeline(&self.pipelines.composite[usize::from(!air)]);
        pass.set_bind_group(0, view.frame_group(), &[]);
        pass.set_bind_group(1, scene, &[]);
        pass.draw(0..3, 0..1);
    }
}
