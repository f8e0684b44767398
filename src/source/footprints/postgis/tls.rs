//! Encryption: which servers are trusted, by libpq's `sslmode` and `sslrootcert` (PostgreSQL manual, section 34.19).

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rustls::client::danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier};
use rustls::client::{verify_server_cert_signed_by_trust_anchor, verify_server_name};
use rustls::crypto::{CryptoProvider, verify_tls12_signature, verify_tls13_signature};
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, ServerName, UnixTime};
use rustls::server::ParsedCertificate;
use rustls::{
    CertificateError, ClientConfig, DigitallySignedStruct, Error as TlsError, RootCertStore, SignatureScheme,
};
use tokio_postgres_rustls::MakeRustlsConnect;
use x509_cert::Certificate;
use x509_cert::der::Decode;

use super::address::{Address, Trust};
use crate::error::InputError;

/// The `sslrootcert` that means the roots of the operating system.
const SYSTEM: &str = "system";

/// What encrypts the connection to a server.
///
/// # Errors
/// The server is to be verified and there is no root certificate to do it by.
pub(super) fn connector(address: &Address) -> Result<MakeRustlsConnect, InputError> {
    let trust = address.trust()?;
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let authorities = if address.is_local() { None } else { authorities(address, trust)? };
    // With the roots of the system anyone may have a certificate: only the name tells.
    let checks_name = trust == Trust::VerifyFull;
    let verifier = Arc::new(Verifier { provider: provider.clone(), authorities, checks_name });
    let config = ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .map_err(|error| InputError::new(address.label(), error.to_string(), "TLS 1.2 or 1.3"))?
        .dangerous()
        .with_custom_certificate_verifier(verifier)
        .with_no_client_auth();
    Ok(MakeRustlsConnect::new(config))
}

/// By whose word a server is trusted.
#[derive(Debug)]
struct Authorities {
    roots: RootCertStore,
    /// The same certificates as they stand: one of them may be the server's own.
    pinned: Vec<CertificateDer<'static>>,
}

/// The root certificates that count for a connection; `None` when every server is trusted.
fn authorities(address: &Address, trust: Trust) -> Result<Option<Authorities>, InputError> {
    let label = address.label();
    let own = address.home().map(|home| home.join(".postgresql/root.crt"));
    let given = address.get("sslrootcert");
    let is_verified = matches!(trust, Trust::VerifyCa | Trust::VerifyFull);
    let file = match (trust, given) {
        (Trust::Disable | Trust::Prefer, _) => return Ok(None),
        (_, Some(SYSTEM)) if trust != Trust::VerifyFull => {
            let found = format!("sslrootcert=system with sslmode={}", trust.name());
            let fault = InputError::new(label, found, "sslmode=verify-full, without which any server would pass");
            return Err(fault);
        }
        (_, Some(SYSTEM)) => {
            let found = rustls_native_certs::load_native_certs();
            return store(&label, Path::new("the system"), found.certs).map(Some);
        }
        (_, Some(file)) => PathBuf::from(file),
        (_, None) => match own.filter(|file| file.is_file()) {
            Some(file) => file,
            None if is_verified => {
                let found = format!("sslmode={} and no root certificate", trust.name());
                let remedy = "Give sslrootcert=FILE, or sslrootcert=system for the roots of this machine";
                return Err(InputError::new(label, found, "one to verify the server by").remedy(remedy));
            }
            None => return Ok(None),
        },
    };
    let read = CertificateDer::pem_file_iter(&file).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let certificates = read.map_err(|error| {
        InputError::new(&label, format!("`sslrootcert` {}: {error}", file.display()), "certificates in PEM form")
    })?;
    store(&label, &file, certificates).map(Some)
}

fn store(label: &Path, file: &Path, certificates: Vec<CertificateDer<'static>>) -> Result<Authorities, InputError> {
    let mut roots = RootCertStore::empty();
    let (usable, _) = roots.add_parsable_certificates(certificates.iter().cloned());
    if usable == 0 {
        let found = format!("no usable certificate in `sslrootcert` ({})", file.display());
        return Err(InputError::new(label, found, "certificates in PEM form"));
    }
    Ok(Authorities { roots, pinned: certificates })
}

/// Verifies servers as libpq does.
#[derive(Debug)]
struct Verifier {
    provider: Arc<CryptoProvider>,
    /// `None` trusts every server.
    authorities: Option<Authorities>,
    /// Whether the certificate must be made out to the host.
    checks_name: bool,
}

impl ServerCertVerifier for Verifier {
    fn verify_server_cert(
        &self,
        end_entity: &CertificateDer<'_>,
        intermediates: &[CertificateDer<'_>],
        server_name: &ServerName<'_>,
        _ocsp_response: &[u8],
        now: UnixTime,
    ) -> Result<ServerCertVerified, TlsError> {
        let Some(Authorities { roots, pinned }) = &self.authorities else {
            return Ok(ServerCertVerified::assertion());
        };
        let certificate = ParsedCertificate::try_from(end_entity)?;
        // A certificate that the server signed itself is its own root, which the library takes for no server's.
        if pinned.iter().any(|pinned| pinned == end_entity) {
            is_in_time(end_entity, now)?;
        } else {
            let algorithms = self.provider.signature_verification_algorithms.all;
            verify_server_cert_signed_by_trust_anchor(&certificate, roots, intermediates, now, algorithms)?;
        }
        if self.checks_name {
            verify_server_name(&certificate, server_name)?;
        }
        Ok(ServerCertVerified::assertion())
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, TlsError> {
        verify_tls12_signature(message, certificate, signature, &self.provider.signature_verification_algorithms)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, TlsError> {
        verify_tls13_signature(message, certificate, signature, &self.provider.signature_verification_algorithms)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.provider.signature_verification_algorithms.supported_schemes()
    }
}

/// Whether a certificate is valid now, by its dates.
fn is_in_time(certificate: &CertificateDer<'_>, now: UnixTime) -> Result<(), TlsError> {
    let parsed = Certificate::from_der(certificate).map_err(|_| CertificateError::BadEncoding)?;
    let validity = parsed.tbs_certificate.validity;
    let seconds = now.as_secs();
    if seconds < validity.not_before.to_unix_duration().as_secs() {
        return Err(CertificateError::NotValidYet.into());
    }
    if seconds > validity.not_after.to_unix_duration().as_secs() {
        return Err(CertificateError::Expired.into());
    }
    Ok(())
}
