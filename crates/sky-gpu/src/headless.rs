//! Pictures without a window: a device of one's own, a target, and its pixels back.

use thiserror::Error;

use crate::renderer::{SkyRenderer, Timing};
use crate::tier::Tier;
use crate::view::View;

/// Largest picture that is drawn \[pixels a side\].
pub const LARGEST_SIDE: u32 = 8192;

/// What can go wrong without a window.
#[derive(Debug, Error)]
pub enum HeadlessError {
    /// No driver.
    #[error(
        "GPU: expected a Vulkan, Metal or Direct3D 12 driver, found none ({0}); on Debian or Ubuntu \
         install mesa-vulkan-drivers for a software one, or use --backend cpu"
    )]
    NoAdapter(#[from] wgpu::RequestAdapterError),
    /// A driver that gives no device.
    #[error("GPU: expected a device, found none ({0})")]
    NoDevice(#[from] wgpu::RequestDeviceError),
    /// A size that cannot be drawn.
    #[error("size: expected 1 to {LARGEST_SIDE} pixels a side, found {width}x{height}")]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// The device is gone.
    #[error("GPU: expected the picture, found a lost device ({0})")]
    Lost(String),
}

/// A device without a window.
#[derive(Debug)]
pub struct Headless {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What it is.
    pub info: wgpu::AdapterInfo,
    /// Nanoseconds of a tick of render-pass timestamps, where the device has them.
    pub timestamp_ns: Option<f32>,
}

/// Whether a picture can have so many pixels across and down.
///
/// # Errors
/// When it cannot.
pub fn check_size([width, height]: [u32; 2]) -> Result<(), HeadlessError> {
    let fits = |side| (1..=LARGEST_SIDE).contains(&side);
    if !fits(width) || !fits(height) {
        return Err(HeadlessError::Size { width, height });
    }
    Ok(())
}

impl Headless {
    /// Opens the fastest device there is, a software one at the worst. At WebGL2's limits, so that
    /// what runs here runs in a browser.
    ///
    /// # Errors
    /// When there is none.
    pub fn new() -> Result<Self, HeadlessError> {
        Self::with_features(wgpu::Features::empty())
    }

    /// The same with features of wgpu that it must have.
    ///
    /// # Errors
    /// When there is no device, or none with these features.
    pub fn with_features(required: wgpu::Features) -> Result<Self, HeadlessError> {
        let mut wanted = wgpu::InstanceDescriptor::new_without_display_handle();
        wanted.backends = wgpu::Backends::PRIMARY;
        let instance = wgpu::Instance::new(wanted);
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        }))?;
        let timed = adapter.features() & wgpu::Features::TIMESTAMP_QUERY;
        let (device, queue) =
            pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
                label: Some("sky"),
                required_features: timed | required,
                required_limits:
                    wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits()),
                ..wgpu::DeviceDescriptor::default()
            }))?;
        let timestamp_ns = (!timed.is_empty()).then(|| queue.get_timestamp_period());
        Ok(Self {
            info: adapter.get_info(),
            device,
            queue,
            timestamp_ns,
        })
    }

    /// A target for pictures.
    ///
    /// # Errors
    /// When the size cannot be drawn.
    pub fn target(
        &self,
        [width, height]: [u32; 2],
        format: wgpu::TextureFormat,
    ) -> Result<wgpu::Texture, HeadlessError> {
        check_size([width, height])?;
        Ok(self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST
                | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        }))
    }

    /// Draws a view's sky on a target, what `over` adds, and submits it.
    pub fn draw(
        &self,
        renderer: &SkyRenderer,
        view: &mut View,
        target: &wgpu::TextureView,
        tier: Tier,
        over: impl FnOnce(&View, &mut wgpu::RenderPass<'_>),
    ) {
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.prepare(&self.queue, &mut encoder, view, tier);
        let mut pass = Self::pass(&mut encoder, target, None);
        renderer.draw(&mut pass, view);
        over(view, &mut pass);
        drop(pass);
        self.queue.submit([encoder.finish()]);
    }

    /// Begins a pass on a target, cleared to black.
    #[must_use]
    pub fn pass<'a>(
        encoder: &'a mut wgpu::CommandEncoder,
        view: &'a wgpu::TextureView,
        timing: Option<Timing<'a>>,
    ) -> wgpu::RenderPass<'a> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: None,
            timestamp_writes: timing.map(|t| wgpu::RenderPassTimestampWrites {
                query_set: t.queries,
                beginning_of_pass_write_index: Some(t.first),
                end_of_pass_write_index: Some(t.first + 1),
            }),
            occlusion_query_set: None,
            multiview_mask: None,
        })
    }

    /// The bytes of a target, row by row without gaps.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn read(&self, texture: &wgpu::Texture) -> Result<Vec<u8>, HeadlessError> {
        let bytes_per_pixel = texture.format().block_copy_size(None).unwrap_or(4);
        let row = texture.width() * bytes_per_pixel;
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("pixels"),
            size: u64::from(padded) * u64::from(texture.height()),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded),
                    rows_per_image: None,
                },
            },
            texture.size(),
        );
        self.queue.submit([encoder.finish()]);
        let bytes = self.mapped(&buffer)?;
        let (row, padded) = (row as usize, padded as usize);
        Ok(bytes
            .chunks_exact(padded)
            .flat_map(|r| &r[..row])
            .copied()
            .collect())
    }

    /// The bytes of a buffer that can be mapped.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn mapped(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, HeadlessError> {
        buffer.map_async(wgpu::MapMode::Read, .., |_| {});
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| HeadlessError::Lost(e.to_string()))?;
        let view = buffer
            .get_mapped_range(..)
            .map_err(|e| HeadlessError::Lost(e.to_string()))?;
        Ok(view.to_vec())
    }
}
