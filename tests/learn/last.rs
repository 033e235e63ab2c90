//! The studies of the last transducer in `evaluate`.

use tertius_testing::support;

const CONFIG: &str = "config/e-type-simulated.toml";

#[test]
fn both_studies_give_the_same_bytes_on_any_number_of_threads() {
    let run = |threads: &str, seed: &str| {
        let rows = ["--rows", "last,single", "--sea", "2.5,8", "--trials", "1", "--hours", "0.01"];
        let call = ["evaluate", "--config", CONFIG, "--threads", threads, "--seed", seed];
        support::tertius(&[&call[..], &rows].concat(), b"").ok().stdout
    };
    let one = run("1", "3");
    assert_eq!(one, run("2", "3"));
    assert_eq!(one.lines().filter(|line| line.contains("drift 100 mm/s")).count(), 12 + 4, "{one}");
    for word in ["noise 6 σ", "broken wire", "absent", "10 mm off", "last one named"] {
        assert!(one.contains(word), "{word:?} is not in\n{one}");
    }
}
