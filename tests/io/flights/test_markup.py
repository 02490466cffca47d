"""Text in XML is text, whatever it holds."""

from xml.etree import ElementTree

from hypothesis import given
from hypothesis import strategies as st

from sooner.io.flights.markup import branch, document, empty, leaf


@given(st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs", "Cn"])))
def test_text_comes_back_as_it_was(said):
    root = ElementTree.fromstring(document(branch("a", [leaf("b", said), empty("c", {"d": said})], {"e": said})))
    assert (root.find("b").text or "") == root.find("c").get("d") == root.get("e") == said


@given(st.text(st.characters()))
def test_no_text_breaks_a_file(said):
    root = ElementTree.fromstring(document(branch("a", [leaf("b", said), empty("c", {"d": said})])))
    assert len(root) == 2
    assert len(root.find("b").text or "") == len(root.find("c").get("d")) == len(said)
