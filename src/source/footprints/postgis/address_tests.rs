//! What connection strings mean, and what of them is never shown.

use super::*;

fn address(text: &str, environment: &[(&str, &str)]) -> Result<Address, InputError> {
    let text = text_of(Path::new(text)).unwrap().to_owned();
    Address::with(&text, &|name| environment.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned()))
}

#[test]
fn only_connection_strings_are_taken_for_databases() {
    for text in ["PG:", "pg:dbname=x", "postgresql://h/d", "postgres://"] {
        assert!(text_of(Path::new(text)).is_some(), "{text}");
    }
    for text in ["P", "PG", "pgdata.gpkg", "x/PG:dbname=x", "http://h/d", "é"] {
        assert!(text_of(Path::new(text)).is_none(), "{text}");
    }
}

#[test]
fn keywords_and_urls_say_the_same() {
    let settings = ["host", "port", "dbname", "user", "password", "sslmode"];
    let of = |text: &str| {
        let address = address(text, &[]).unwrap();
        settings.map(|name| address.get(name).map(str::to_owned)).map(Option::unwrap_or_default)
    };
    let expected = ["db.example.org", "5433", "my city", "an'a", "p w:@/x", "require"].map(str::to_owned);
    let words = r"PG: host=db.example.org port = 5433 dbname='my city' user=an\'a password='p w:@/x' sslmode=require ";
    assert_eq!(of(words), expected);
    assert_eq!(of("postgresql://an'a:p%20w%3A%40%2Fx@db.example.org:5433/my%20city?sslmode=require"), expected);
    assert_eq!(of("PG:postgres://an'a:p%20w%3A@%2Fx@db.example.org:5433/my%20city?ssl=true"), expected);
    let several = address("postgres://u@[::1]:5433,%2Frun/d", &[]).unwrap();
    assert_eq!((several.get("host"), several.get("port")), (Some("::1,/run"), Some("5433,5432")));
}

#[test]
fn the_environment_stands_in_and_what_is_given_goes_before_it() {
    let environment = [
        ("PGHOST", "h"),
        ("PGPASSWORD", "secret"),
        ("PGUSER", "me"),
        ("PGCONNECT_TIMEOUT", "3"),
        ("PGSSLMODE", "verify-full"),
    ];
    let address = address("PG:user=you sslmode=disable", &environment).unwrap();
    assert_eq!(
        (address.get("host"), address.get("user"), address.get("dbname")),
        (Some("h"), Some("you"), Some("you"))
    );
    assert_eq!(address.password(), (Some("secret".to_owned()), None));
    assert_eq!((address.trust().unwrap(), address.patience()), (Trust::Disable, Some(Duration::from_secs(3))));
    assert_eq!(address.label(), Path::new("PG:user=you"));
}

#[test]
fn nothing_of_a_password_is_shown_whatever_is_wrong_with_the_string() {
    for text in [
        "PG:user=u password=hun ter2",
        "PG:user=u password=hun ter2=x",
        "PG:user=u password='hunter2",
        "PG:user=u password=hunter2 port=hunter2",
        "PG:user=u password=hunter2 sslmode=hunter2",
        "PG:user=u password=hunter2 service=x",
        "postgresql://u:hunter2@[::1",
        "postgresql://u:hunter2",
        "postgresql://u:hunter2@h/d?hunter2",
        "postgresql://u:hunter2@h/d?hunter2=1",
    ] {
        let made = address(text, &[]).and_then(|address| address.config(Some("hunter2")).map(drop));
        let message = made.unwrap_err().to_string();
        assert!(!message.contains("ter2") && message.contains("expected"), "{text}: {message}");
    }
    let message = address("PG:tables=a", &[]).map(drop).unwrap_err().to_string();
    assert!(message.contains("`tables`"), "{message}");
    let shown = address("postgresql://u:hunter2@h/d", &[]).unwrap().label();
    assert_eq!(shown, Path::new("PG:user=u host=h dbname=d"));
}

#[test]
fn sockets_are_not_encrypted() {
    let mode = |text| address(text, &[]).unwrap().config(None).unwrap().get_ssl_mode();
    assert_eq!(mode("PG:host=/run user=u sslmode=require"), SslMode::Disable);
    assert_eq!(mode("PG:host=h user=u"), SslMode::Prefer);
    assert_eq!(mode("PG:host=h user=u sslmode=verify-full"), SslMode::Require);
}
