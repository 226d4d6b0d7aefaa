"""Folders of DDS Security for a test, made by openssl: an authority, and identities that it signed."""
import pathlib
import subprocess

GOVERNANCE = """<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
     xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>0</min><max>230</max></id_range></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
"""

PERMISSIONS = """<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
     xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name="relay">
      <subject_name>{subject}</subject_name>
      <validity><not_before>2020-01-01T00:00:00</not_before><not_after>2099-01-01T00:00:00</not_after></validity>
      <allow_rule>
        <domains><id_range><min>0</min><max>230</max></id_range></domains>
        <publish><topics><topic>*</topic></topics></publish>
        <subscribe><topics><topic>*</topic></topics></subscribe>
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
"""


def openssl(*arguments, folder):
    subprocess.run(["openssl", *map(str, arguments)], cwd=folder, check=True, capture_output=True)


class Authority:
    """Signs identities, and what they may do."""

    def __init__(self, folder: pathlib.Path, name: str):
        self.folder = folder
        folder.mkdir()
        openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", 100,
                "-subj", f"/CN={name}", "-keyout", "ca_key.pem", "-out", "ca.pem", folder=folder)

    def identity(self, name: str) -> pathlib.Path:
        """The folder for --security of one relay."""
        folder = self.folder / name
        folder.mkdir()
        openssl("req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-subj", f"/CN={name}",
                "-keyout", "key.pem", "-out", "request.pem", folder=folder)
        openssl("x509", "-req", "-in", "request.pem", "-CA", "../ca.pem", "-CAkey", "../ca_key.pem", "-CAcreateserial",
                "-days", 100, "-out", "identity.pem", folder=folder)
        for ca in "identity_ca.pem", "permissions_ca.pem":
            (folder / ca).write_bytes((self.folder / "ca.pem").read_bytes())
        self.sign(folder, "governance", GOVERNANCE)
        self.sign(folder, "permissions", PERMISSIONS.format(subject=f"CN={name}"))
        return folder

    def sign(self, folder: pathlib.Path, name: str, text: str):
        (folder / f"{name}.xml").write_text(text)
        openssl("smime", "-sign", "-in", f"{name}.xml", "-text", "-out", f"{name}.p7s", "-signer", "../ca.pem",
                "-inkey", "../ca_key.pem", folder=folder)
