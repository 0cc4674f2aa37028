//! The backend of a picture by a method that was asked for, if the backend is left open.

use lighting::methods::Work;

use super::chosen::Chosen;
use crate::devices::{self, BackendName, Device};
use crate::failure::Failure;
use crate::format::seconds;
use crate::plan;

/// The backend that is expected to have a picture of this work first, by what is known of the
/// machine, and a note about it. A GPU is started only if it is that backend.
pub(super) fn device(
    chosen: &Chosen,
    work: &Work,
    rays: usize,
) -> Result<(Device, Option<String>), Failure> {
    let cpu = devices::find_one(BackendName::Cpu)?;
    let name = chosen.entry.about().name;
    if !chosen.entry.runs_on_gpus() {
        let why = format!("left out: the GPU ({name} has no shader)");
        return Ok((cpu, Some(why)));
    }
    let profile = plan::known_costs()?;
    let expected = |backend: &str| profile.first_picture(backend, &name, work, rays);
    let all = profile.starts();
    let all = all.map(|(backend, start)| (backend, start, expected(backend)));
    let Some((backend, start, on_gpu)) = all.min_by(|a, b| a.2.total_cmp(&b.2)) else {
        let why = "left out: the GPU (the time that it takes to start is not known; see plan \
                   --calibrate)";
        return Ok((cpu, Some(why.into())));
    };
    let on_cpu = expected(&cpu.label);
    if on_gpu >= on_cpu {
        let why = format!(
            "left out: {backend} (starting it takes {}, and all of the picture {} on the CPU; \
             saves {})",
            seconds(start),
            seconds(on_cpu),
            seconds(on_gpu - on_cpu)
        );
        return Ok((cpu, Some(why)));
    }
    let (present, _) = devices::find(&[])?;
    let mut others = present.into_iter();
    match others.find(|device| device.label == backend) {
        Some(gpu) => {
            let on = seconds(on_gpu);
            let why = format!(
                "on {backend}: expected after {on}, on the CPU {}",
                seconds(on_cpu)
            );
            Ok((gpu, Some(why)))
        }
        None => Ok((cpu, Some(format!("left out: {backend} (it is not here)")))),
    }
}
