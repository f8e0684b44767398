use super::*;
#[test]
fn smoke() {
    let mut bad = 0;
    let start = std::time::Instant::now();
    for seed in 0..500 {
        if let Err(e) = building(seed) {
            bad += 1;
            println!("{e}");
        }
    }
    println!("{bad} bad in {:?}", start.elapsed());
    let mut random = Random::new(99);
    let mut flaws = std::collections::BTreeMap::<String, (usize, String)>::new();
    for _ in 0..500 {
        if let Err(e) = principal::draw(&mut random).finish() {
            let text = format!("{e:?}");
            let entry = flaws.entry(text.chars().take(40).collect()).or_default();
            entry.0 += 1;
            entry.1 = text;
        }
    }
    println!("{flaws:#?}");
}
