//! Several parts at a time, each in a process of its own with a CPU driver on one thread: most kernels of small systems are too short to be
//! shared among cores.

use crate::case::Trouble;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

/// What the processes do.
pub struct Jobs<'a> {
    /// How many run at a time.
    pub count: usize,
    /// Arguments of every process, after the name of its part.
    pub arguments: Vec<String>,
    /// Begin none after this time.
    pub duration: Option<Duration>,
    /// Names of the parts, CASE/PART, the longest first.
    pub parts: Vec<&'a str>,
}

/// Runs them all and prints what they say, each as soon as it has ended; true if all of it is good.
///
/// # Errors
/// If a part could not be measured; the others are finished first.
pub fn run(jobs: &Jobs<'_>) -> Result<bool, Trouble> {
    let began = Instant::now();
    let program = std::env::current_exe()?;
    let queue = Mutex::new(jobs.parts.iter());
    let (sender, ended) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..jobs.count {
            let (sender, queue, program) = (sender.clone(), &queue, &program);
            scope.spawn(move || {
                let next = || queue.lock().ok().and_then(|mut parts| parts.next());
                while let Some(part) = next() {
                    if jobs.duration.is_some_and(|d| began.elapsed() >= d) {
                        println!("{part}: left for the next call");
                        continue;
                    }
                    // llvmpipe's number of threads.
                    let mut command = Command::new(program);
                    command.arg(part).args(&jobs.arguments).env("LP_NUM_THREADS", "1").stderr(Stdio::inherit());
                    if sender.send((*part, command.output())).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        let (mut good, mut trouble) = (true, Vec::new());
        for (part, output) in ended {
            let output = output.map_err(|e| format!("{part}: {e}"))?;
            print!("{}", String::from_utf8_lossy(&output.stdout));
            match verdict(output.status) {
                Some(well) => good &= well,
                None => trouble.push(part),
            }
        }
        if trouble.is_empty() { Ok(good) } else { Err(format!("could not be measured: {}", trouble.join(", ")).into()) }
    })
}

/// Whether all that a process measured is good; none if it could not.
fn verdict(status: ExitStatus) -> Option<bool> {
    status.code().filter(|code| *code < 2).map(|code| code == 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::process::ExitStatusExt;

    #[test]
    fn a_process_that_breaks_down_has_measured_nothing() {
        assert_eq!(verdict(ExitStatus::from_raw(0)), Some(true));
        assert_eq!(verdict(ExitStatus::from_raw(1 << 8)), Some(false));
        assert_eq!(verdict(ExitStatus::from_raw(2 << 8)), None);
        assert_eq!(verdict(ExitStatus::from_raw(101 << 8)), None);
        assert_eq!(verdict(ExitStatus::from_raw(9)), None);
    }
}
