//! Whether a control group stops this program for part of each period.

use std::path::Path;

use super::{Finding, line_of};

const GROUPS: &str = "/sys/fs/cgroup";

pub(super) fn probe() -> Finding {
    let memberships = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    finding(narrowest(Path::new(GROUPS), &memberships))
}

fn finding(share: Option<f64>) -> Finding {
    match share {
        Some(share) => Finding::warning(
            format!("a control group stops this program after {share:.1} processors' worth of each period"),
            "remove the CPU limit of the container; a throttled filter sleeps through whole periods",
        ),
        None => Finding::good("no processor quota"),
    }
}

/// Smallest share among the groups of this process and those around them, in processors. `memberships` is
/// `/proc/self/cgroup`: lines `number:controllers:path`, without controllers in version 2.
fn narrowest(root: &Path, memberships: &str) -> Option<f64> {
    let mut shares = Vec::new();
    for line in memberships.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else { continue };
        let inner = Path::new(path.trim_start_matches('/'));
        for group in inner.ancestors() {
            if controllers.is_empty() {
                shares.extend(line_of(root.join(group).join("cpu.max")).and_then(|text| share(&text)));
            } else if controllers.split(',').any(|controller| controller == "cpu") {
                let folder = root.join(controllers).join(group);
                let quota = line_of(folder.join("cpu.cfs_quota_us"));
                let period = line_of(folder.join("cpu.cfs_period_us"));
                shares.extend(
                    quota.zip(period).and_then(|(quota, period)| share(&format!("{quota} {period}"))),
                );
            }
        }
    }
    shares.into_iter().min_by(f64::total_cmp)
}

/// `text` holds quota and period in µs; a quota of `max` or -1 is none.
fn share(text: &str) -> Option<f64> {
    let (quota, period) = text.split_once(' ')?;
    let (quota, period) = (quota.parse::<f64>().ok()?, period.parse::<f64>().ok()?);
    (quota >= 0.0 && period > 0.0).then_some(quota / period)
}

#[cfg(test)]
mod tests {
    use super::super::Severity;
    use super::*;

    #[test]
    fn a_quota_is_told_from_none() {
        assert_eq!(share("max 100000"), None);
        assert_eq!(share("-1 100000"), None);
        assert_eq!(share("150000 100000"), Some(1.5));
        assert_eq!(finding(None).severity, Severity::Good);
        assert!(finding(Some(1.5)).what.contains("1.5"));
        assert_eq!(finding(Some(1.5)).severity, Severity::Warning);
    }

    #[test]
    fn the_narrowest_of_the_groups_around_counts_in_either_version() {
        let root = std::env::temp_dir().join(format!("cncbf_quota_{}", std::process::id()));
        let write = |path: &str, text: &str| {
            let file = root.join(path);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(file, text).unwrap();
        };
        write("cpu.max", "max 100000\n");
        write("robots/cpu.max", "50000 100000\n");
        write("robots/one/cpu.max", "200000 100000\n");
        write("cpu,cpuacct/job/cpu.cfs_quota_us", "25000\n");
        write("cpu,cpuacct/job/cpu.cfs_period_us", "100000\n");
        assert_eq!(narrowest(&root, "0::/robots/one\n"), Some(0.5));
        assert_eq!(narrowest(&root, "0::/\n"), None);
        assert_eq!(narrowest(&root, "4:memory:/job\n3:cpu,cpuacct:/job\n0::/robots/one\n"), Some(0.25));
        assert_eq!(narrowest(&root, "4:memory:/job\n"), None);
        std::fs::remove_dir_all(&root).unwrap();
    }
}
