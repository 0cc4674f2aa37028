//! A device for people who have none.

use std::sync::Arc;

use super::Context;
use super::context::Loss;
use crate::Error;

/// Environment variable with a part of the name of the adapter to take.
pub const ADAPTER_VARIABLE: &str = "CREPUSCULAR_ADAPTER";

impl Context {
    /// Opens the best adapter: a discrete GPU before an integrated or virtual
    /// one, anything before a software driver. The environment variable
    /// [`ADAPTER_VARIABLE`] narrows the choice to adapters whose name contains
    /// its value, in any case.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] with the reason: no driver compiled in, no adapter
    /// present, none of that name, or none that opens.
    pub fn request() -> Result<Self, Error> {
        let name = std::env::var(ADAPTER_VARIABLE).unwrap_or_default();
        Self::request_named(&name, None)
    }

    /// Opens the best adapter whose name contains `name` (any, if it is empty),
    /// with the given limits or else all that the adapter offers.
    ///
    /// # Errors
    /// [`Error::NoAdapter`].
    pub fn request_named(name: &str, limits: Option<wgpu::Limits>) -> Result<Self, Error> {
        let no_adapter = |reason: String| Err(Error::NoAdapter { reason });
        if wgpu::Instance::enabled_backend_features().is_empty() {
            return no_adapter("no driver of wgpu is compiled in".into());
        }
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
        adapters.retain(|adapter| {
            adapter
                .get_downlevel_capabilities()
                .flags
                .contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
        });
        if adapters.is_empty() {
            return no_adapter("no driver offers one that runs compute shaders".into());
        }
        let all: Vec<String> = adapters.iter().map(|a| a.get_info().name).collect();
        let wanted = name.to_lowercase();
        adapters.retain(|adapter| adapter.get_info().name.to_lowercase().contains(&wanted));
        if adapters.is_empty() {
            return no_adapter(format!("none is called {name:?}; there are {all:?}"));
        }
        adapters.sort_by_key(|adapter| rank(adapter.get_info().device_type));
        let mut refusals = Vec::new();
        for adapter in &adapters {
            match open(adapter, limits.clone()) {
                Ok(context) => return Ok(context),
                Err(error) => refusals.push(format!("{}: {error}", adapter.get_info().name)),
            }
        }
        no_adapter(refusals.join("; "))
    }
}

fn rank(kind: wgpu::DeviceType) -> u8 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

fn open(
    adapter: &wgpu::Adapter,
    limits: Option<wgpu::Limits>,
) -> Result<Context, wgpu::RequestDeviceError> {
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("crepuscular"),
        // Only ever used to tell the time.
        required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
        required_limits: limits.unwrap_or_else(|| adapter.limits()),
        ..wgpu::DeviceDescriptor::default()
    }))?;
    let loss = Loss::default();
    let report = Arc::clone(&loss);
    device.set_device_lost_callback(move |reason, message| {
        // Only the first reason counts.
        report.set(format!("{reason:?}, {message}")).ok();
    });
    Ok(Context::with_loss(device, queue, loss))
}
