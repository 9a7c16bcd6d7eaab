"""Forged and sealed certificates, as made by someone who knows their structure."""

from __future__ import annotations

import io
import json
import re
import warnings
from datetime import UTC, datetime

from rigrunner.proof.seal import seal, unsealed

VALUE = re.compile(r'(<p class="value">[^(<]*\()(\d+[.,]\d+)')


def resealed(path, change):
    """Change a document and seal it again; `change` takes and returns its bytes."""
    path.write_bytes(seal(change(unsealed(path.read_bytes(), path.suffix)), path.suffix))


def with_content(page, change):
    """Change the JSON in an HTML page, written by `json`; `change` takes a dict."""
    before, mark, script = page.partition(b'id="certificate">\n')
    data, end, after = script.partition(b"</script>")
    content = json.loads(data)
    change(content)
    text = json.dumps(content, ensure_ascii=False, indent=1)
    escaped = text.translate({ord(sign): f"\\u{ord(sign):04x}" for sign in "<>&"})
    return before + mark + escaped.encode() + b"\n" + end + after


def with_banner(page, printed="0.4268"):
    """Show another result on a page, with a banner above it."""
    text, count = VALUE.subn(rf"\g<1>{printed}", page.decode("utf-8"))
    assert count == 1
    banner = '<div style="font-size: 3rem">Best in test</div>'
    return text.replace("<body>", f"<body>\n{banner}", 1).encode()


def forged_pdf(path, printed="0.1000"):
    """Replace a PDF by one that shows another result, with the true data attached."""
    from weasyprint import HTML, Attachment  # noqa: PLC0415  (optional)

    page, count = VALUE.subn(rf"\g<1>{printed}", path.with_suffix(".html").read_text("utf-8"))
    assert count == 1
    data = unsealed(path.with_suffix(".json").read_bytes(), ".json").decode()
    pdf = HTML(string=page).write_pdf(
        attachments=[Attachment(string=data, name=f"{path.stem}.json")]
    )
    path.write_bytes(seal(pdf, ".pdf"))
    return printed


def sealed_pdf(content, box=None, name="Seal"):
    """Seal a PDF by PAdES with a new key, invisibly or in a box on its first page."""
    from pyhanko.sign import fields, signers  # noqa: PLC0415  (loads much)

    meta = signers.PdfSignatureMetadata(field_name=name, subfilter=fields.SigSeedSubFilter.PADES)
    field = fields.SigFieldSpec(name, box=box, on_page=0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its dependencies
        signer = signers.PdfSigner(meta, signer=_signer(), new_field_spec=field)
        sealed = signer.sign_pdf(incremental(content)).getvalue()
    assert sealed.startswith(content)
    return sealed


def incremental(content):
    """Return a writer that appends to a PDF."""
    from pyhanko.pdf_utils.incremental_writer import (  # noqa: PLC0415  (loads much)
        IncrementalPdfFileWriter,
    )

    return IncrementalPdfFileWriter(io.BytesIO(content))


def appended(content, change):
    """Append to a PDF the changes that `change` makes to its objects."""
    writer, out = incremental(content), io.BytesIO()
    change(writer)
    writer.write(out)
    return out.getvalue()


def _signer():
    from cryptography import x509  # noqa: PLC0415  (optional)
    from cryptography.hazmat.primitives import hashes  # noqa: PLC0415
    from cryptography.hazmat.primitives.asymmetric import ec  # noqa: PLC0415
    from cryptography.hazmat.primitives.serialization import NoEncryption, pkcs12  # noqa: PLC0415
    from pyhanko.sign import signers  # noqa: PLC0415

    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "Accredited laboratory")])
    usage = x509.KeyUsage(
        digital_signature=True, content_commitment=True, key_encipherment=False,
        data_encipherment=False, key_agreement=False, key_cert_sign=False, crl_sign=False,
        encipher_only=False, decipher_only=False,
    )  # fmt: skip
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(1)
        .not_valid_before(datetime(2026, 1, 1, tzinfo=UTC))
        .not_valid_after(datetime(2046, 1, 1, tzinfo=UTC))
        .add_extension(usage, critical=True)
        .sign(key, hashes.SHA256())
    )
    packed = pkcs12.serialize_key_and_certificates(b"seal", key, certificate, None, NoEncryption())
    return signers.SimpleSigner.load_pkcs12_data(packed, other_certs=[])
