//! `gmpcr register`: from scans to poses, pose graph, merged cloud and report.

mod summary;

use std::path::Path;

use gmpcr::register_observed;
use serde_json::json;

use crate::arguments::RegisterArguments;
use crate::config::Config;
use crate::input::Input;
use crate::outcome::{Answer, Failure};
use crate::output::{FILES, Output, prepare};
use crate::progress::Progress;
use crate::result::ResultFile;
use crate::scan_files::files_of;
use crate::warnings::in_words;
use summary::summary;

pub fn run(
    arguments: &RegisterArguments,
    is_verbose: bool,
    progress: &Progress,
) -> Result<Answer, Failure> {
    let config = Config::new(&arguments.tuning)?;
    let files = files_of(&arguments.inputs)?;
    prepare(&arguments.out, &files)?;
    let input = match &arguments.descriptors {
        Some(folder) => Input::with_descriptors(&files, folder, &config, progress)?,
        None => Input::with_fpfh(&files, &config, progress)?,
    };
    check_number(&input)?;
    let params = config.params(input.set.voxel_size);
    let registration =
        register_observed(&input.set.scans, &params, progress).map_err(Failure::of_registration)?;
    let warnings = in_words(&input, &registration);
    let world_from_local = registration.world_from_scan.clone();
    let graph = input.set.posed_graph(&registration);
    let registration = input.set.in_cloud_frames(registration);
    let result = ResultFile::new(&input, &config, registration, warnings);
    let voxel_size = input.set.voxel_size;
    let output = Output {
        title: &title(arguments),
        input: &input,
        graph: &graph,
        result: &result,
        world_from_local: &world_from_local,
        downsample: arguments.downsample.map(|size| size.unwrap_or(voxel_size)),
    };
    output.write(&arguments.out, progress)?;
    progress.finish();
    Ok(Answer {
        text: summary(&result, is_verbose) + &written(&arguments.out),
        json: Some(json!(result)),
        is_complete: result.registration.components.members().len() == 1,
    })
}

/// A single scan would be in place, but nobody means that.
fn check_number(input: &Input) -> Result<(), Failure> {
    let files = input.files.iter();
    let problems: Vec<_> = files.filter_map(|file| file.problem.as_deref()).collect();
    let (num_files, num_readable) = (input.files.len(), input.files.len() - problems.len());
    if num_readable >= 2 {
        return Ok(());
    }
    let first = problems.first();
    let first = first.map_or(String::new(), |problem| format!("; {problem}"));
    let reason =
        format!("{num_readable} of {num_files} scans could be read: at least two are needed");
    Err((reason + &first).into())
}

/// The folder of the first input, or of the descriptors.
fn title(arguments: &RegisterArguments) -> String {
    let first = arguments.inputs.first().or(arguments.descriptors.as_ref());
    let first = first.and_then(|path| path.canonicalize().ok());
    let folder = first.map(|path| match path.is_dir() {
        true => path,
        false => path.parent().map(Path::to_owned).unwrap_or(path),
    });
    let name = folder.as_deref().and_then(Path::file_name);
    name.map_or("scans".into(), |name| name.to_string_lossy().into_owned())
}

fn written(folder: &Path) -> String {
    let names = FILES.map(|(name, _)| name);
    format!("\n{} written to {}\n", names.join(", "), folder.display())
}
