from __future__ import annotations

from rigrunner.proof.places import place_in

HTML = b"""<!doctype html>
<head><style>p {}</style></head>
<h1>Test certificate</h1>
<p>C-0001</p>
<h2 id="r">Results <span>of
 the test</span></h2>
<p>0.7273</p>
"""
PDF = b"""%PDF-1.7
1 0 obj
<</Type /Page /Contents 3 0 R>>
endobj
2 0 obj
<</Type /Pages /Kids [1 0 R]>>
endobj
3 0 obj
<</Length 3>> stream
abc
endstream
endobj
"""


def place(content, text, suffix):
    start = content.index(text)
    return place_in(content, suffix, start, start + len(text))


def test_place_in_html_is_given_by_its_heading():
    assert place(HTML, b"0.7273", ".html").endswith(", line 7 (section 'Results of the test')")
    assert place(HTML, b"C-0001", ".html").endswith(", line 4 (section 'Test certificate')")
    assert place(HTML, b"doctype", ".html").endswith(", line 1 (beginning)")
    lines = place(HTML, b"C-0001</p>\n<h2", ".html")
    assert lines.endswith(
        ", lines 4 to 5 (section 'Test certificate', section 'Results of the test')"
    )


def test_place_in_json_is_given_by_its_member():
    content = b'{\n "number": "C-1",\n "customer": {\n  "name": "Acme"\n }\n}\n'
    assert place(content, b"Acme", ".json") == "bytes 46 to 49, line 4 (customer)"


def test_place_in_a_pdf_is_given_by_object_and_page():
    assert place(PDF, b"abc", ".pdf").endswith("(object 3, page 1)")
    assert place(PDF, b"/Kids", ".pdf").endswith("(object 2)")
