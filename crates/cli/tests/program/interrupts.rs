//! Ctrl-C, and requests to terminate.

#![cfg(unix)]

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use crate::common::{Run, Workplace, program, room, write_ply};

/// Runs the program, which gets a signal after a while, and must end as one that was interrupted.
fn interrupted(signal: &str, milliseconds: u64, arguments: &[&str]) {
    let mut command = program(arguments);
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    sleep(Duration::from_millis(milliseconds));
    let id = child.id().to_string();
    let killed = Command::new("kill").args([signal, &id]).status().unwrap();
    assert!(killed.success(), "the program was over before");
    let run: Run = child.wait_with_output().unwrap().into();
    assert_eq!(run.code, Some(130), "{}{}", run.stdout, run.stderr);
    assert!(run.stderr.contains("interrupted"), "{}", run.stderr);
}

#[test]
fn an_interrupt_ends_the_work_between_two_files() {
    let place = Workplace::new();
    let scans = place.create("scans");
    // Work for seconds: every scan many times.
    for k in 0..60 {
        write_ply(&scans.join(format!("scan_{k}.ply")), &room().clouds[k % 6]);
    }
    let (scans, out) = (place.text("scans"), place.text("out"));
    interrupted("-INT", 300, &["register", &scans, "-o", &out]);
    assert!(
        place
            .files("out")
            .iter()
            .all(|name| !name.ends_with(".part"))
    );
    interrupted("-INT", 300, &["info", &scans]);
}

#[test]
fn a_request_to_terminate_ends_even_what_has_no_items() {
    let place = Workplace::new();
    // A chain of thousands of poses, solved again and again.
    let edge = |i: usize| {
        let j = i + 1;
        format!("EDGE_SE3:QUAT {i} {j} 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n")
    };
    let graph: String = (0..5000).map(edge).collect();
    let graph = place.write("chain.g2o", graph);
    interrupted("-TERM", 500, &["sync", &graph, "--iterations", "100000"]);
}
