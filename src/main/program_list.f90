!> --list: what the program knows, from the same tables the deck is read with.
module program_list
  use command_table, only: load_commands
  use command_type, only: command_row_t
  use contact_table, only: load_contact_laws
  use contact_type, only: contact_law_t
  use element_table, only: load_elements
  use element_type, only: element_t
  use material_table, only: load_materials
  use material_type, only: material_t
  implicit none
  private
  public :: print_list

contains

  !> kind: elements, materials, contacts, commands; anything else: all of them.
  subroutine print_list(kind)
    character(*), intent(in) :: kind

    if (wanted('elements')) call list_elements()
    if (wanted('materials')) call list_materials()
    if (wanted('contacts')) call list_contacts()
    if (wanted('commands')) call list_commands()

  contains

    logical function wanted(name)
      character(*), intent(in) :: name

      wanted = kind == name .or. kind == ''
    end function wanted

  end subroutine print_list

  subroutine list_elements()
    type(element_t), allocatable :: table(:)
    integer :: i

    call load_elements(table)
    print '(a)', 'elements'
    do i = 1, size(table)
      print '(2x,a,2x,a)', table(i)%name, trim(table(i)%source)
    end do
  end subroutine list_elements

  subroutine list_materials()
    type(material_t), allocatable :: table(:)
    integer :: i

    call load_materials(table)
    print '(a)', 'materials'
    do i = 1, size(table)
      print '(2x,a,2x,a)', table(i)%name, trim(table(i)%source)
    end do
  end subroutine list_materials

  subroutine list_contacts()
    type(contact_law_t), allocatable :: table(:)
    integer :: i

    call load_contact_laws(table)
    print '(a)', 'contacts'
    do i = 1, size(table)
      print '(2x,a,2x,a)', table(i)%name, trim(table(i)%source)
      print '(20x,a)', trim(table(i)%usage)
    end do
  end subroutine list_contacts

  subroutine list_commands()
    type(command_row_t), allocatable :: table(:)
    integer :: i

    call load_commands(table)
    print '(a)', 'commands'
    do i = 1, size(table)
      print '(2x,a,2x,a)', table(i)%word, trim(table(i)%usage)
    end do
  end subroutine list_commands

end module program_list
