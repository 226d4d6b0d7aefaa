"""For Python's Markdown: lists nest by two spaces, as everywhere else."""
import markdown


class TwoSpaces(markdown.Extension):
    def extendMarkdown(self, md):
        md.tab_length = 2


def makeExtension(**settings):
    return TwoSpaces(**settings)
