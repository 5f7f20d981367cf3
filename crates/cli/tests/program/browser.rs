//! The report in a real browser.

use std::path::Path;
use std::process::Command;

use crate::common::{Run, Workplace};

/// Runs `web/check.mjs`, which needs Node.js, its package in `web/node_modules`, and Chromium.
#[test]
fn the_report_works_in_a_browser() {
    let web = Path::new(env!("CARGO_MANIFEST_DIR")).join("web");
    let browser = std::env::var("GMPCR_BROWSER").unwrap_or("/usr/bin/chromium".into());
    let has_packages = web.join("node_modules/playwright-core").is_dir();
    if !has_packages || !Path::new(&browser).exists() {
        eprintln!(
            "skipped: needs {browser} (see GMPCR_BROWSER) and `npm ci` in {}",
            web.display()
        );
        return;
    }
    let place = Workplace::with_scans();
    place.register(0, "scans", "out", &[]);
    let check = web.join("check.mjs");
    let output = Command::new("node")
        .arg(check)
        .arg(place.path("out/report.html"))
        .output()
        .unwrap();
    let run = Run::from(output);
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
}
